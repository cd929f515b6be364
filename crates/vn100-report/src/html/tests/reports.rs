//! The report of a record, and of two.

use vn100_analysis::SourceResult;

use crate::{
    figure::ReportFigures,
    html::{PageOptions, Program, report_page},
    tests::fixture::{in_a_warming_room, with_attitude},
};

/// The report of these records.
fn report(records: &[SourceResult]) -> String {
    let options = PageOptions {
        confidence: 0.95,
        asked: "as asked",
        words: crate::remedies::page_words,
        program: Program { name: "vn100 test", commit: None },
        span_s: 60.0,
    };
    report_page(records, &ReportFigures::of(records), options)
}

/// The text between the elements of a piece of a page.
fn texts(html: &str) -> impl Iterator<Item = &str> {
    html.split('<').map(|piece| piece.split_once('>').map_or(piece, |(_, text)| text))
}

/// The text of a piece of a page, with spaces that break.
fn text(html: &str) -> String {
    texts(html).collect::<String>().replace('\u{a0}', " ")
}

/// The cells of a row.
fn cells(row: &str) -> String {
    texts(row).filter(|text| !text.is_empty()).collect::<Vec<_>>().join(" | ")
}

/// The text of the row with this heading.
fn row(page: &str, heading: &str) -> String {
    let (_, row) = page.split_once(&format!("<th scope=\"row\">{heading}</th>")).unwrap_or_else(|| panic!("{heading}"));
    cells(row.split_once("</tr>").unwrap().0)
}

#[track_caller]
fn has(page: &str, pieces: &[&str]) {
    for piece in pieces {
        assert!(page.contains(piece), "{piece}");
    }
}

#[test]
fn the_temperature_coefficient_of_each_axis_stands_in_all_units() {
    let page = report(&[in_a_warming_room(32_768)]);
    let begin = page.find("temperature coefficient of the bias").unwrap();
    let rows: Vec<String> = page[begin..].split("</tr>").take(6).map(cells).collect();
    assert_eq!(
        rows,
        [
            "temperature coefficient of the bias | rad/s/°C | 5.02 (4.83 to 5.17)·10⁻⁵ | −0.1 (−1.9 to 1.7)·10⁻⁶ | −0.5 (−1.6 to 1.7)·10⁻⁶",
            "°/s/°C | 2.876·10⁻³ | −6.804·10⁻⁶ | −3.001·10⁻⁵",
            "°/h/°C | 10.35 | −0.02449 | −0.1080",
            "lag behind the temperature | s | 0 (0 to 1.2) | – | –",
            "p without the coefficient | &lt; 10⁻⁹ | 1.0 | 1.0",
            "largest share of temperature in an octave of the level | % | 100 | – | –",
        ]
    );
}

#[test]
fn a_grade_names_the_values_that_decide() {
    let page = text(&report(&[in_a_warming_room(32_768)]));
    has(&page, &["Grade. gyro_x: at least ", " °/h, the sensor's own N ≤ 0.11"]);
}

#[test]
fn the_notes_on_the_parameters_say_what_to_do() {
    let page = report(&[with_attitude(8192, 40.0)]);
    has(&page, &["<ol class=\"notes\"><li>measure with message VNIMU (register 6)</li>"]);
}

#[test]
fn the_statistics_have_the_magnitude_of_each_sensor() {
    let page = report(&[with_attitude(8192, 40.0)]);
    has(&page, &["its deviations are no sensor noise"]);
    let norm = "8\u{202f}192 | 0.001112356 | 0.000195199 | 0.000447 | 0.001810 | – | –";
    assert_eq!(row(&page, "gyro_norm"), norm);
}

#[test]
fn a_page_ends_with_what_was_not_tested() {
    let page = text(&report(&[with_attitude(8192, 40.0)]));
    has(
        &page,
        &[
            "sensitivity to temperature, supply and acceleration",
            "its averaging window, calibration",
            "were not recorded.",
        ],
    );
}

#[test]
fn densities_that_fold_differently_are_not_compared() {
    let of = |rate_hz| report(&[with_attitude(4096, 40.0), with_attitude(4096, rate_hz)]);
    let said = "N is not compared: aliasing may raise it differently in them, by unknown factors. ";
    assert_eq!((of(40.0).matches(said).count(), of(50.0).matches(said).count()), (0, 3));
}
