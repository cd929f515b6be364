//! A chart with two logarithmic axes: its grid, and where values lie in it.

use ratatui::{
    buffer::Buffer,
    layout::{Position, Rect},
    style::Style,
};

use crate::{panels::curve::LogAxis, theme::Theme};

/// Columns left of the plot, for the labels of its grid.
pub(crate) const LABELS: u16 = 7;

/// Both axes and where they are on the screen.
#[derive(Clone, Copy)]
pub(crate) struct ChartAxes {
    pub(crate) x: LogAxis,
    pub(crate) y: LogAxis,
    pub(crate) chart: Rect,
}

impl ChartAxes {
    pub(crate) fn column(self, tau_s: f64) -> Option<u16> {
        let part = self.x.part(tau_s)?;
        Some(self.chart.x + (part * f64::from(self.chart.width - 1)).round() as u16)
    }

    pub(crate) fn row(self, deviation: f64) -> Option<u16> {
        let part = self.y.part(deviation)?;
        Some(self.chart.bottom() - 1 - (part * f64::from(self.chart.height - 1)).round() as u16)
    }

    /// So many columns in decimal logarithms of the horizontal axis.
    pub(crate) fn logarithm_of_columns(self, columns: i32) -> f64 {
        f64::from(columns) * (self.x.high - self.x.low) / f64::from(self.chart.width - 1)
    }

    /// Whether a point, in logarithms, is in the chart.
    pub(crate) fn within(self, (x, y): (f64, f64)) -> bool {
        (self.x.low..=self.x.high).contains(&x) && (self.y.low..=self.y.high).contains(&y)
    }
}

pub(crate) fn put(buffer: &mut Buffer, x: u16, y: u16, text: &str, style: Style) {
    for (x, sign) in (x..).zip(text.chars()) {
        if let Some(cell) = buffer.cell_mut(Position::new(x, y)) {
            cell.set_char(sign).set_style(style);
        }
    }
}

pub(crate) fn draw_grid(buffer: &mut Buffer, axes: ChartAxes, label_row: u16, theme: Theme, label: &str) {
    let chart = axes.chart;
    let columns = axes.x.ticks(usize::from(chart.width / 9));
    let rows = axes.y.ticks(usize::from(chart.height / 2));
    for tick in &rows {
        let Some(row) = axes.row(10_f64.powf(tick.at)) else { continue };
        put(buffer, chart.x, row, &"┈".repeat(chart.width.into()), theme.faint());
        let width = tick.label.len() as u16;
        put(buffer, chart.x.saturating_sub(width + 1), row, &tick.label, Style::new());
    }
    for tick in &columns {
        let Some(column) = axes.column(10_f64.powf(tick.at)) else { continue };
        for row in chart.top()..chart.bottom() {
            put(buffer, column, row, "┊", theme.faint());
        }
        let width = tick.label.len() as u16;
        let label = column.saturating_sub(width / 2).min(chart.right().saturating_sub(width));
        put(buffer, label, label_row, &tick.label, Style::new());
    }
    put(buffer, chart.x.saturating_sub(LABELS), label_row, &theme.spelled(label), theme.faint());
}

/// A place of the horizontal axis, marked at the top and at the bottom: a line between the two would look like the bar of a point.
pub(crate) fn draw_cursor(buffer: &mut Buffer, axes: ChartAxes, x: f64) {
    if let Some(column) = axes.column(x) {
        for row in [axes.chart.top(), axes.chart.bottom() - 1] {
            put(buffer, column, row, "│", Style::new());
        }
    }
}

/// Points between the given ones, close enough for a line of dots; in logarithms.
pub(crate) fn dense(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    const BETWEEN: u32 = 8;
    let logs: Vec<_> = points.iter().map(|(x, y)| (x.log10(), y.log10())).collect();
    logs.windows(2)
        .flat_map(|pair| {
            (0..BETWEEN).map(|step| {
                let part = f64::from(step) / f64::from(BETWEEN);
                (pair[0].0 + part * (pair[1].0 - pair[0].0), pair[0].1 + part * (pair[1].1 - pair[0].1))
            })
        })
        .collect()
}
