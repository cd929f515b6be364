//! Properties that hold for any bytes, in pieces of any size.

use std::io;

use proptest::prelude::*;

use super::*;

/// Returns its bytes in pieces of the given sizes, in turn.
struct Pieces {
    bytes: Cursor<Vec<u8>>,
    sizes: std::iter::Cycle<std::vec::IntoIter<usize>>,
}

impl Read for Pieces {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let size = self.sizes.next().unwrap_or(1).min(buffer.len());
        self.bytes.read(&mut buffer[..size])
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
            let Ok(Some(plan)) = detect(&bytes, Said { map, ..Said::default() }) else { continue };
            let at_once = read_all(plan.clone(), Cursor::new(bytes.clone()));
            // a second table with other columns ends the first one
            if at_once.error.is_none() {
                prop_assert_eq!(at_once.report.lines, lines(&bytes, &plan));
                prop_assert_eq!(at_once.bytes.iter().sum::<u64>(), bytes.len() as u64);
            }
            let pieces = Pieces { bytes: Cursor::new(bytes.clone()), sizes: sizes.clone().into_iter().cycle() };
            prop_assert_eq!(read_all(plan, pieces), at_once);
        }
    }

    #[test]
    fn no_bytes_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300), text in "[-+0-9.,;\te\"#$ gyro_xtraw\r\n]{0,300}") {
        let map = "gyro_x=1:deg/s".parse().unwrap();
        for bytes in [&bytes[..], text.as_bytes()] {
            for map in [None, Some(&map)] {
                if let Ok(Some(plan)) = detect(bytes, Said { map, ..Said::default() }) {
                    let expected = lines(bytes, &plan);
                    let whole = read_all(plan, Cursor::new(bytes.to_vec()));
                    prop_assert!(whole.error.is_some() || whole.report.lines == expected);
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

}
