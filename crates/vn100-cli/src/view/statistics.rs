//! All channels: mean, standard deviation, extremes, and the last minute as a line of bars.

use ratatui::{
    Frame,
    layout::{Constraint, Rect},
    text::{Line, Span},
    widgets::{Row, Table},
};
use vn100_protocol::Quantity;
use vn100_report::units::fitted;

use super::{
    scene::{Regions, Scene, framed},
    source::Source,
    state::Panel,
};

pub(crate) fn draw(frame: &mut Frame<'_>, area: Rect, scene: Scene<'_>, source: &Source, regions: &mut Regions) {
    let block = framed(scene, Panel::Statistics, "Statistics".into());
    let inner = block.inner(area);
    frame.render_widget(block, area);
    let chosen = scene.state.channel(source);
    // the places of names, units and numbers; what is left belongs to the bars
    let longest = source.values.iter().map(|channel| channel.name.len()).max().unwrap_or(0) as u16;
    let name = if inner.width >= 100 { longest.clamp(8, 24) } else { 8 };
    let widths = [name, 6, 11, 10, 9, 9];
    let fixed: u16 = widths.iter().sum::<u16>() + widths.len() as u16;
    let bars = inner.width.saturating_sub(fixed);
    let axes: Vec<(usize, usize)> = (source.groups().iter())
        .flat_map(|group| group.channels.iter().copied().enumerate().collect::<Vec<_>>())
        .map(|(axis, channel)| (channel, axis))
        .collect();
    // what was asked for between the lines is no axis
    let mut polled: Vec<usize> = (axes.len()..source.values.len()).collect();
    polled.sort_by_key(|place| !matches!(source.values[*place].quantity, Quantity::Temperature | Quantity::Pressure));
    let placed: Vec<(usize, usize)> =
        axes.into_iter().chain(polled.into_iter().map(|place| (place, usize::MAX))).collect();
    regions.channels = placed.iter().enumerate().map(|(row, (place, _))| (inner.y + 1 + row as u16, *place)).collect();
    let rows = placed.into_iter().map(|(place, axis)| {
        let channel = &source.values[place];
        let number = |value: Option<f64>, decimals: usize, column: usize| {
            let text = value.map_or("-".into(), |value| fitted(value, decimals, widths[column].into()));
            Line::raw(text).right_aligned()
        };
        // averages resolve more than one sample
        let finer = channel.decimals + 2;
        let row = Row::new(vec![
            Line::from(Span::styled(channel.name.clone(), scene.theme.axis(axis))),
            Line::raw(channel.unit.clone()),
            number(channel.mean, finer, 2),
            number(channel.std, finer, 3),
            number(channel.min, channel.decimals, 4),
            number(channel.max, channel.decimals, 5),
            Line::from(Span::styled(source.sparkline(place, usize::from(bars)), scene.theme.axis(axis))),
        ]);
        if Some(place) == chosen { row.style(scene.theme.chosen()) } else { row }
    });
    let header = ["channel", "unit", "mean", "std", "min", "max"]
        .iter()
        .enumerate()
        .map(|(place, name)| if place < 2 { Line::raw(*name) } else { Line::raw(*name).right_aligned() });
    let recent = match bars {
        0..8 => "",
        8..12 => "recent",
        _ => "last minutes",
    };
    let header = header.chain([Line::raw(recent)]);
    let header = Row::new(header).style(scene.theme.faint());
    let widths = widths.into_iter().map(Constraint::Length).chain([Constraint::Length(bars)]);
    frame.render_widget(Table::new(rows, widths).column_spacing(1).header(header), inner);
}
