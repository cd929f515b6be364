//! The instrument of the browser tab gives the documents of `vn100 report`, and names what it needs.

use std::{fs, path::Path, sync::Arc};

use serde_json::Value;
use vn100_web::{Request, Tab};

use crate::support::{capture, real_captures, replay_log, vn100};

fn measured(path: &Path, request: Request) -> (Tab, Vec<vn100_web::Answer>) {
    let file: Arc<[u8]> = fs::read(path).unwrap().into();
    let name = path.file_name().unwrap().to_string_lossy().into_owned();
    let mut tab = Tab::default();
    let answers = tab.measure(&file, &Request { name, ..request }, &mut |_| {}).unwrap();
    (tab, answers)
}

/// The documents of the tab.
fn documents(tab: &Tab) -> Vec<Value> {
    let names = tab.outputs().into_iter().map(|output| output.file).filter(|file| file.ends_with(".json"));
    names.map(|name| serde_json::from_str(&tab.output(&name).unwrap()).unwrap()).collect()
}

#[test]
fn a_file_gives_the_documents_of_the_program() {
    let folder = tempfile::tempdir().unwrap();
    let recording = capture(folder.path(), "vnimu.txt", &["--message", "VNIMU", "--duration", "60s"]);
    let mut files: Vec<_> =
        ["clean-minute.vnymr", "corrupted.vnymr", "gaps.vnymr", "binary-between.bin"].map(replay_log).to_vec();
    files.push(recording);
    files.extend(real_captures().into_iter().flat_map(|real| {
        ["vn100-static1hz-ramirez-run2-623s.csv", "vn100-circles-qian-95s-GAPS.vnymr"].map(|name| real.join(name))
    }));
    for path in files {
        let page = folder.path().join("x.html");
        let report = vn100().arg("report").arg(&path).args(["--export", "json", "--force", "-o"]).arg(&page).output();
        assert!(report.unwrap().status.success(), "{}", path.display());
        let (tab, answers) = measured(&path, Request::default());
        assert!(answers.iter().all(|answer| answer.error.is_none() && answer.cure.is_none()), "{answers:?}");
        let theirs: Value = serde_json::from_slice(&fs::read(page.with_extension("json")).unwrap()).unwrap();
        assert_eq!(documents(&tab), [theirs], "{}", path.display());
        let outputs = tab.outputs();
        assert!(outputs.iter().all(|output| output.missing.is_some() != tab.output(&output.file).is_some()));
    }
}

#[test]
fn what_a_file_does_not_say_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let cure = |content: &str, request: Request| {
        let path = folder.path().join("a.csv");
        fs::write(&path, content).unwrap();
        let (tab, mut answers) = measured(&path, request);
        assert_eq!(answers.len(), 1);
        let answer = answers.remove(0);
        assert_eq!(answer.error.is_some(), answer.cure.is_some(), "{answer:?}");
        // no option of the command line
        assert!(!answer.error.iter().any(|error| error.contains(" --")), "{answer:?}");
        (answer.cure, tab)
    };
    let rows: String = (0..200).map(|row| format!("{}\n", (row * 7919 % 13) as f64 * 0.01)).collect();
    let table = format!("gyro_x [rad/s]\n{rows}");
    let (rate, _) = cure(&table, Request::default());
    assert_eq!(rate.unwrap().field, "rate");
    let (nothing, tab) = cure(&table, Request { rate_hz: Some(100.0), ..Request::default() });
    assert!(nothing.is_none() && tab.page().is_some());
    let (columns, tab) = cure("a;b;c\n1.5;2;x\n1.25;3;y\n1.75;2.5;z\n", Request::default());
    assert_eq!(columns.unwrap().field, "columns");
    assert_eq!(tab.page(), None);
}

#[test]
fn numbers_that_cannot_be_used_are_refused_in_words() {
    let file: Arc<[u8]> = b"$VNYMR"[..].into();
    for (request, word) in [
        (Request { rate_hz: Some(0.0), ..Request::default() }, "rate"),
        (Request { rate_hz: Some(f64::NAN), ..Request::default() }, "rate"),
        (Request { window: Some(801), ..Request::default() }, "window"),
        (Request { skip_s: Some(-1.0), ..Request::default() }, "time"),
        (Request { columns: Some("gyro_x".into()), ..Request::default() }, "columns"),
        (Request { datasheet: Some("none".into()), ..Request::default() }, "data sheet"),
    ] {
        let error = Tab::default().measure(&file, &request, &mut |_| {}).unwrap_err();
        assert!(error.contains(word), "{error}");
    }
}
