//! What holds for any bytes, however they are cut.

use std::io::{self, Read};

use proptest::prelude::*;

use super::*;

/// Hands out its bytes in pieces of the given sizes, over and over.
struct Pieces<'a> {
    bytes: &'a [u8],
    sizes: std::iter::Cycle<std::vec::IntoIter<usize>>,
}

impl Read for Pieces<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let size = self.sizes.next().unwrap_or(1).min(buffer.len());
        (&mut self.bytes).take(size as u64).read(buffer)
    }
}

/// A file with valid rows, rejected ones, and bytes replaced, inserted and cut anywhere.
fn damaged_file() -> impl Strategy<Value = Vec<u8>> {
    let line = prop_oneof![
        6 => Just(format!("1761939167.192566,{VALUES}\n")),
        3 => Just(format!("1761939168,\"{SENTENCE}\"\r\n")),
        2 => Just(format!("-3.5,{SENTENCE}\n")),
        1 => Just(format!("1,\"{SENTENCE}\r\n\"\r\n")),
        1 => Just("# a comment\n".to_owned()),
        1 => Just("\n".to_owned()),
        1 => Just("9,1e300,nan,-0.00000000000000000000001e5,,\"1\",+,.,1e,0,0,0,0\r\n".to_owned()),
        1 => "[-+0-9.,e\" ]{0,40}\n",
    ];
    let header = prop_oneof![Just(HEADER), Just("t,raw"), Just("raw_data,t"), Just("# t,gyro_x")];
    let damage = proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..3_u8), 0..6);
    (header, proptest::collection::vec(line, 0..40), damage, any::<bool>()).prop_map(|(header, lines, damage, bom)| {
        let mut bytes = if bom { BYTE_ORDER_MARK.to_vec() } else { Vec::new() };
        bytes.extend_from_slice(header.as_bytes());
        bytes.push(b'\n');
        lines.iter().for_each(|line| bytes.extend_from_slice(line.as_bytes()));
        for (at, byte, action) in damage {
            let at = at.index(bytes.len());
            match action {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                _ if bytes.len() > 1 => drop(bytes.remove(at)),
                _ => {}
            }
        }
        bytes
    })
}

fn lines(bytes: &[u8], plan: &CsvPlan) -> u64 {
    let ends = bytes.iter().filter(|&&byte| byte == plan.line_end).count();
    let unfinished = bytes.last().is_some_and(|&byte| byte != plan.line_end);
    (ends + usize::from(unfinished)) as u64
}

proptest! {
    #[test]
    fn every_line_is_counted_once_however_the_file_is_cut(bytes in damaged_file(), sizes in proptest::collection::vec(1_usize..200, 1..8)) {
        let map = "gyro_x=2:deg/s,temperature=3:K,t=1:s".parse().unwrap();
        for map in [None, Some(&map)] {
            let Ok(Some(plan)) = detect(&bytes, map, None) else { continue };
            let at_once = read(plan.clone(), &bytes[..]);
            prop_assert_eq!(at_once.report.lines, lines(&bytes, &plan));
            prop_assert_eq!(at_once.bytes.iter().sum::<u64>(), bytes.len() as u64);
            let pieces = Pieces { bytes: &bytes, sizes: sizes.clone().into_iter().cycle() };
            prop_assert_eq!(read(plan, pieces), at_once);
        }
    }

    #[test]
    fn no_bytes_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300), text in "[-+0-9.,;\te\"#$ gyro_xtraw\r\n]{0,300}") {
        let map = "gyro_x=1:deg/s".parse().unwrap();
        for bytes in [&bytes[..], text.as_bytes()] {
            for map in [None, Some(&map)] {
                if let Ok(Some(plan)) = detect(bytes, map, None) {
                    let expected = lines(bytes, &plan);
                    prop_assert_eq!(read(plan, bytes).report.lines, expected);
                }
            }
        }
    }

    #[test]
    fn printed_counts_are_restored(counts in proptest::collection::vec(-2_000_000_i32..2_000_000, 2..60), decimals in 1_usize..7, exponents: bool) {
        let mut text = "gyro_x\n".to_owned();
        for count in &counts {
            let field = if exponents {
                format!("{count}e-{decimals}\n")
            } else {
                let sign = if *count < 0 { "-" } else { "" };
                let digits = format!("{:0width$}", count.unsigned_abs(), width = decimals + 1);
                let (whole, fraction) = digits.split_at(digits.len() - decimals);
                format!("{sign}{whole}.{fraction}\n")
            };
            text.push_str(&field);
        }
        let plan = plan(&text, Some("gyro_x=gyro_x:deg/s")).unwrap().unwrap();
        prop_assume!(counts.iter().any(|&count| count != 0));
        prop_assert_eq!(usize::from(layout(&plan).channels[0].decimals), decimals);
        prop_assert_eq!(read(plan, text.as_bytes()).counts, counts);
    }

    /// Floats of any size, as many programs print them.
    #[test]
    fn no_row_is_lost_whatever_follows(
        sizes in proptest::collection::vec((-30_i32..30, 1_usize..400), 1..5),
        form in 0..6_usize,
        seed: u32,
    ) {
        let mut state = seed | 1;
        let mut uniform = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state) / f64::from(u32::MAX) - 0.5
        };
        let numbers: Vec<f64> =
            sizes.iter().flat_map(|&(size, rows)| std::iter::repeat_n(size, rows)).map(|size| uniform() * 2_f64.powi(size)).collect();
        let printed = |number: f64| match form {
            0 => format!("{number}"),
            1 => format!("{number:.18e}"),
            2 => format!("{number:.8}"),
            3 => format!("{number:.3}"),
            4 => format!("{}", number as f32),
            _ => format!("{number:e}"),
        };
        let text = format!("w,x\n{}", numbers.iter().map(|&number| format!("{},1\n", printed(number))).collect::<String>());
        let plan = whole_plan(&text, Some("value=1:V,gyro_x=2:deg/s"));
        let channels = layout(&plan).channels;
        let place = channels.iter().position(|channel| channel.name == "value").unwrap();
        let channel = &channels[place];
        let whole = read(plan, text.as_bytes());
        prop_assert_eq!((whole.counts.len(), whole.rejected_rows()), (2 * numbers.len(), 0));
        let file = |number: &f64| printed(*number).parse::<f64>().unwrap();
        let largest = numbers.iter().map(|number| file(number).abs()).fold(0.0, f64::max);
        let held = numbers.iter().zip(whole.counts.chunks(2)).map(|(number, row)| (file(number), channel.value(row[place])));
        let beyond = held.filter(|(number, held)| (number - held).abs() > 2_f64.powi(-31) * largest).count();
        // of a thousand numbers one may be a glitch
        prop_assert!(beyond as f64 <= 1e-3 * numbers.len() as f64, "{} beyond", beyond);
        let absent: u64 = whole.report.absent.iter().map(AbsentValues::total).sum();
        prop_assert!(absent >= beyond as u64);
    }
}
