//! What the pages say of a record.

mod reports;

use super::*;
use crate::remedies::page_words;
use crate::tests::fixture::with_attitude;

#[test]
fn a_live_page_has_a_place_for_each_part_and_figures_with_the_numbers_that_are_read_off_them() {
    let record = with_attitude(4096, 40.0);
    let options = PageOptions {
        confidence: 0.95,
        asked: "as asked",
        words: page_words,
        program: Program { name: "vn100 test", commit: None },
        span_s: 60.0,
    };
    let parts = result_parts(&record, options);
    let page = live_page(ShownPage::Source("a"), |_| None, "7-1", "vn100 test");
    for part in &parts {
        assert_eq!(page.matches(&format!("<section id=\"{}\"></section>", part.id)).count(), 1, "{}", part.id);
        let figures = part.html.matches("<figure ").count();
        assert_eq!(figures > 0, ["allan", "axes", "spectrum"].contains(&part.id), "{}", part.id);
        let readings = part.html.split("<script type=\"application/json\">").skip(1);
        let readings: Vec<serde_json::Value> =
            readings.map(|rest| serde_json::from_str(rest.split("</script>").next().unwrap()).unwrap()).collect();
        assert_eq!(readings.len(), figures, "{}", part.id);
        assert!(readings.iter().all(|reading| reading["series"][0]["y"][0].is_number()), "{}", part.id);
    }
    assert!(page.contains("<section id=\"now\"></section>") && !page.contains("id=\"filters\""));
}
