//! The figures of a record.

use super::fixture::{at_rest, long_at_rest};
use crate::figure::{Figure, Figures};

fn figure<'a>(figures: &'a [Figure], id: &str) -> &'a Figure {
    let all: Vec<&str> = figures.iter().map(|figure| &*figure.id).collect();
    figures.iter().find(|figure| figure.id == id).unwrap_or_else(|| panic!("{id} is not among {all:?}"))
}

/// How often a figure has this piece of text.
fn count(figure: &Figure, piece: &str) -> usize {
    figure.svg_element().matches(piece).count()
}

#[test]
fn the_figures_of_a_source_under_way_are_those_of_its_noise() {
    let measured = at_rest(4096, &[]);
    let figures = Figures::live(&measured);
    let ids: Vec<&str> = figures.all().map(|figure| &*figure.id).collect();
    let of_sensors = |kind: &str| ["gyro", "accel", "mag"].map(|sensor| format!("{kind}-{sensor}"));
    let axes = ["gyro", "accel", "mag"].map(|sensor| ["x", "y", "z"].map(|axis| format!("allan-{sensor}_{axis}")));
    let expected =
        [&of_sensors("allan")[..], &axes.concat(), &of_sensors("spectrum"), &of_sensors("segments")].concat();
    assert_eq!(ids, expected);
    let ids = |prefix| Figures::of(&measured, prefix).all().map(|figure| figure.id.clone()).collect::<Vec<_>>();
    assert!(ids("run1-").iter().map(|id| id.strip_prefix("run1-").unwrap()).eq(ids("")));
}

/// 15 octaves, of which the last has too few degrees of freedom to be joined to the others.
#[test]
fn each_known_deviation_has_a_symbol_and_an_interval() {
    let figures = Figures::of(long_at_rest(), "");
    let gyro = figure(&figures.allan_sensors, "allan-gyro");
    assert_eq!(gyro.series[0].values.len(), 15);
    let (disc, ring) = ("<circle r=\"3.1\" class=\"a c0\" fill=\"#0072b2\"/>", "<circle r=\"3.1\" class=\"h quiet\"");
    // one in the legend
    assert_eq!((count(gyro, disc), count(gyro, ring)), (1 + 14, 1));
    // a line from end to end, and a shorter one at each
    assert_eq!(count(gyro, "class=\"l c0\" stroke=\"#0072b2\" stroke-width=\"1.1\""), 3 * 14);
}

#[test]
fn a_figure_of_the_data_sheet_for_the_minimum_of_the_curve_is_a_line_at_that_height() {
    let figures = Figures::of(long_at_rest(), "");
    let gyro = figure(&figures.allan_sensors, "allan-gyro");
    assert_eq!(count(gyro, "stroke-dasharray=\"7 3 1.5 3\" d=\"M"), 4 + 2 + 1);
    // at most 10 °/h
    let y = gyro.area.top + gyro.area.height * (1.0 - gyro.y.scale.share(10.0));
    let (left, right) = (gyro.area.left, gyro.area.left + gyro.area.width);
    let line = format!("stroke-dasharray=\"7 3 1.5 3\" d=\"M{left:.1} {y:.1}L{right:.0} {y:.1}\"");
    assert_eq!(count(gyro, &line), 1);
}

#[test]
fn the_legend_of_an_axis_names_the_fitted_model() {
    let figures = Figures::of(long_at_rest(), "");
    let gyro_z = figure(&figures.allan_axes, "allan-gyro_z");
    for entry in [">fitted model</text>", ">graphical method</text>", ">N 0.10", ">B ≤ ", ">K "] {
        assert_eq!(count(gyro_z, entry), 1, "{entry}");
    }
}

#[test]
fn the_six_highest_peaks_have_their_frequencies_beside_them() {
    let peaks = [(0.3, 60.0), (0.7, 400.0), (1.5, 50.0), (3.2, 250.0), (6.5, 45.0), (11.0, 150.0), (17.9, 350.0)];
    let measured = at_rest(32_768, &peaks);
    let figures = Figures::of(&measured, "");
    let accel = figure(&figures.spectra, "spectrum-accel");
    assert_eq!(count(accel, " Hz</text>"), 6);
}

#[test]
fn deviations_of_segments_begin_at_zero() {
    let measured = at_rest(4096, &[]);
    let figures = Figures::of(&measured, "");
    let scale = figure(&figures.segments, "segments-gyro").y.scale;
    assert_eq!((scale.from, scale.log), (0.0, false));
    assert_eq!(scale.share(scale.to / 2.0), 0.5);
}

#[test]
fn the_normal_curve_lies_in_a_layer_of_its_own_above_the_bars() {
    let figures = Figures::of(long_at_rest(), "");
    let svg = figure(&figures.histograms, "histogram-gyro_x").svg_element();
    let layers: Vec<&str> = svg.split("class=\"data series ").skip(1).map(|layer| &layer[..2]).collect();
    assert_eq!(layers, ["s0", "s1"]);
}
