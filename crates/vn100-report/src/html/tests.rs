//! What the pages say of a record.

mod reports;

use super::*;
use crate::remedies::page_words;
use crate::{figure::Figures, tests::fixture::with_attitude};

#[test]
fn of_several_sources_the_cautions_are_shown_before_their_details_are_opened() {
    let sources = [("run1-".to_owned(), "a".to_owned()), ("run2-".to_owned(), "b".to_owned())];
    for (sources, before) in [(&sources[..], 1), (&sources[..1], 0)] {
        let page = live_page(sources, &[], "7-1", "vn100 test");
        let (brief, details) = page.split_once("<details").unwrap_or(("", &page));
        assert_eq!(brief.matches("id=\"run1-cautions\"").count(), before);
        assert_eq!(details.matches("id=\"run1-allan\"").count(), 1);
    }
}

#[test]
fn parts_with_figures_carry_the_numbers_that_are_read_off_them() {
    let record = with_attitude(4096, 40.0);
    let parts = result_parts(&record, page_words, "run1-");
    for name in ["allan", "axes", "spectrum"] {
        let html = &parts.iter().find(|part| part.id == format!("run1-{name}")).unwrap().html;
        assert!(html.contains("<svg "), "{name}");
        let (_, readings) = html.split_once("<script class=\"readings\" type=\"application/json\">").unwrap();
        let readings: serde_json::Value = serde_json::from_str(readings.strip_suffix("</script>").unwrap()).unwrap();
        let figures = Figures::live(&record, "run1-");
        let expected = match name {
            "allan" => figures.allan_sensors.len(),
            "axes" => figures.allan_axes.len(),
            _ => figures.spectra.len() + figures.segments.len(),
        };
        assert_eq!(readings.as_array().map(Vec::len), Some(expected), "{name}");
    }
}
