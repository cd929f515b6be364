//! Numbers of any form and sign come back as they were printed.

use proptest::prelude::*;

use super::*;

proptest! {
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
