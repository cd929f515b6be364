//! Files with whole sentences in one column and a stamp in another.

use super::*;

/// The sentences of `text` through the decoder, and the file itself.
fn decoded(text: &str) -> (Vec<i32>, Whole) {
    let plan = plan(text, None).unwrap().unwrap();
    assert!(plan.layout.is_none());
    let whole = read(plan, text.as_bytes());
    (whole.counts.clone(), whole)
}

#[test]
fn sentences_are_found_quoted_or_not() {
    for (header, row) in [
        ("t,raw", "1.5,SENTENCE"),
        ("Time,raw_data", "1.5,\"SENTENCE\""),
        ("timestamp, sentence", "1.5, \"SENTENCE\" "),
        ("rosbagTimestamp,data", "1500000000,\"SENTENCE\""),
        ("%time,field.data", "1500000000,SENTENCE"),
        ("bag_t;raw", "1.5;SENTENCE"),
        ("n,raw,t", "7,\"SENTENCE\",1.5"),
        ("t,yaw,gyro_x,raw", "1.5,-85.469,0.000040,SENTENCE"),
        ("t,raw,", "1.5,\"SENTENCE\","),
        ("t,raw", "1.5,\"SENTENCE\","),
        ("t,raw,", "1.5,SENTENCE,"),
        ("t,raw", "1.5,SENTENCE,"),
        ("t,raw", "1.5,\"b'SENTENCE\\r\\n'\""),
    ] {
        for line_end in ["\n", "\r\n"] {
            let row = row.replace("SENTENCE", SENTENCE);
            let (counts, whole) = decoded(&format!("{header}{line_end}{row}{line_end}{row}{line_end}"));
            assert_eq!(counts, [COUNTS, COUNTS].concat(), "{header}");
            assert_eq!(whole.stamps_ns, [0, 0]);
            assert_eq!((whole.report.lines, whole.report.rows, whole.report.skipped_lines), (3, 2, 1));
        }
    }
}

#[test]
fn line_breaks_inside_quotes_are_no_rows() {
    for broken in ["\r\n", "\n", "\r\r\n", "\n\n"] {
        let text = format!("t,raw,n\n1.0,\"{SENTENCE}{broken}\",7\n2.0,\"{SENTENCE}{broken}\",8\n");
        let (counts, whole) = decoded(&text);
        assert_eq!(counts, [COUNTS, COUNTS].concat(), "{broken:?}");
        assert_eq!((whole.report.rows, whole.rejected_rows()), (2, 0));
    }
}

#[test]
fn a_lost_quote_damages_at_most_its_own_row() {
    let text = format!("t,raw,n\n1.0,\"{SENTENCE},7\n2.0,\"{SENTENCE}\",8\n");
    let (counts, whole) = decoded(&text);
    assert!(counts.ends_with(&COUNTS));
    assert_eq!((whole.report.rows, whole.rejected_rows()), (2, 0));
}

#[test]
fn damage_is_left_to_the_checksum() {
    let text = format!("t,raw\n1.0,{SENTENCE}\n2.0,{}\n3.0,{SENTENCE}\n", SENTENCE.replace("085", "095"));
    let (counts, whole) = decoded(&text);
    assert_eq!(counts, [COUNTS, COUNTS].concat());
    assert_eq!(whole.report.rows, 3);
    assert_eq!(whole.stamps_ns, [0, 2_000_000_000]);
}

#[test]
fn rows_without_a_sentence_or_a_stamp_are_rejected() {
    let text = format!("t,raw\n1.0,{SENTENCE}\n2.0,\n3.0\nnow,{SENTENCE}\n,{SENTENCE}\n");
    let (_, whole) = decoded(&text);
    let kinds: Vec<_> = whole.report.rejected.iter().map(|rows| (rows.reason, rows.count)).collect();
    assert_eq!(kinds, [(RejectedRow::Fields, 2), (RejectedRow::Stamp, 2)]);
}

#[test]
fn rows_with_too_many_fields_are_rejected() {
    let text = format!("n,raw,t\n1,\"{SENTENCE}\",1.5\n2,\"{SENTENCE}\",1.5,6\n3,{SENTENCE},2.5\n");
    let (counts, whole) = decoded(&text);
    assert_eq!(counts, [COUNTS, COUNTS].concat());
    assert_eq!(whole.rejected, [1]);
}

#[test]
fn a_column_of_other_data_is_no_column_of_sentences() {
    assert!(plan("t,data\n1,2\n", None).unwrap_err().to_string().ends_with("found t, data"));
    let plan = plan("t,data,gyro_x\n1,2,3\n", None).unwrap().unwrap();
    assert!(plan.layout.is_some());
    assert_eq!(plan.report.ignored_columns, ["data"]);
}

#[test]
fn a_stamp_that_may_be_cut_is_no_stamp() {
    let text = format!("raw,t\n\"{SENTENCE}\",1.500\n\"{SENTENCE}\",1.525\n");
    let rows = |text: &str| (read_text(text, None).report.rows, read_text(text, None).rejected_rows());
    assert_eq!((rows(&text), rows(text.trim_end())), ((2, 0), (1, 1)));
    // a sentence at the end is judged by the decoder
    assert_eq!(rows(&format!("t,raw\n1.5,{SENTENCE}\n1.525,{}", &SENTENCE[..40])), (2, 0));
}

#[test]
fn stamps_before_sentences_are_their_times() {
    for (stamp, reported) in [
        (
            &(|ms: u64| format!("[2024-02-06 18:14:{:02}.{:03}] ", ms / 1000, ms % 1000)) as &dyn Fn(u64) -> String,
            "1:iso",
        ),
        (&|ms| format!("18:14:{:02}.{:03} -> ", ms / 1000, ms % 1000), "1:clock"),
        (&|ms| format!("(1707243251.{:03}) ", ms), "1:s"),
    ] {
        let text: String = (0..20).map(|row| format!("{}{SENTENCE}\r\n", stamp(50 * row))).collect();
        let (counts, whole) = decoded(&format!("boot, at 115200 baud\n{text}"));
        assert_eq!((counts.len(), whole.report.times.as_deref()), (20 * COUNTS.len(), Some(reported)));
        assert_eq!(whole.stamps_ns, (0..20).map(|row| row * 50_000_000).collect::<Vec<_>>());
        assert_eq!(whole.rejected, [0], "the line before is no sentence");
    }
}
