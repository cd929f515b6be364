//! Colours and signs, by what they mean.
//!
//! The colours are those of Okabe and Ito (2008), distinct to nearly everyone; no meaning rests
//! on colour alone.

use std::env;

use ratatui::{
    buffer::Buffer,
    style::{Color, Modifier, Style},
};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Colours {
    /// 24 bits.
    True,
    /// The sixteen that every terminal names.
    Sixteen,
    None,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Theme {
    pub(crate) colours: Colours,
    /// Nothing but ASCII.
    pub(crate) ascii: bool,
}

pub(crate) const SIGNS: [&str; 3] = ["●", "▲", "◆"];

const ORANGE: (u8, u8, u8) = (230, 159, 0);
const SKY_BLUE: (u8, u8, u8) = (86, 180, 233);
const BLUISH_GREEN: (u8, u8, u8) = (0, 158, 115);
const VERMILION: (u8, u8, u8) = (213, 94, 0);
const YELLOW: (u8, u8, u8) = (240, 228, 66);
const REDDISH_PURPLE: (u8, u8, u8) = (204, 121, 167);

impl Theme {
    pub(crate) fn of_terminal() -> Self {
        Self::of(|name| env::var(name).ok().filter(|value| !value.is_empty()))
    }

    fn of(variable: impl Fn(&str) -> Option<String>) -> Self {
        let terminal = variable("TERM").unwrap_or_default();
        let true_colour = variable("COLORTERM").is_some_and(|value| value == "truecolor" || value == "24bit");
        let colours = match variable("NO_COLOR") {
            Some(_) => Colours::None,
            None if true_colour => Colours::True,
            None => Colours::Sixteen,
        };
        let locale = ["LC_ALL", "LC_CTYPE", "LANG"].into_iter().find_map(variable);
        let other_locale = locale.is_some_and(|locale| !locale.to_lowercase().replace('-', "").contains("utf8"));
        // a console without a desktop has few signs in its font
        Self { colours, ascii: other_locale || terminal == "linux" || terminal.starts_with("vt") }
    }

    fn colour(self, exact: (u8, u8, u8), nearest: Color) -> Style {
        match self.colours {
            Colours::True => Style::new().fg(Color::Rgb(exact.0, exact.1, exact.2)),
            Colours::Sixteen => Style::new().fg(nearest),
            Colours::None => Style::new(),
        }
    }

    /// Of the first, second or third axis, unlike that of a judgement; of anything else no colour.
    pub(crate) fn axis(self, axis: usize) -> Style {
        match axis {
            0 => self.colour(ORANGE, Color::LightBlue),
            1 => self.colour(SKY_BLUE, Color::LightCyan),
            2 => self.colour(REDDISH_PURPLE, Color::LightMagenta),
            _ => Style::new(),
        }
    }

    pub(crate) fn good(self) -> Style {
        self.colour(BLUISH_GREEN, Color::Green)
    }

    pub(crate) fn warning(self) -> Style {
        self.colour(YELLOW, Color::Yellow).add_modifier(Modifier::BOLD)
    }

    pub(crate) fn error(self) -> Style {
        match self.colours {
            Colours::None => Style::new().add_modifier(Modifier::REVERSED),
            _ => self.colour(VERMILION, Color::LightRed).add_modifier(Modifier::BOLD),
        }
    }

    /// Beside what matters: grids, frames, labels.
    pub(crate) fn faint(self) -> Style {
        match self.colours {
            Colours::True => Style::new().fg(Color::Rgb(128, 128, 128)),
            Colours::Sixteen => Style::new().fg(Color::DarkGray),
            Colours::None => Style::new().add_modifier(Modifier::DIM),
        }
    }

    pub(crate) fn chosen(self) -> Style {
        Style::new().add_modifier(Modifier::REVERSED)
    }

    /// The colour itself, for what takes no style.
    pub(crate) fn colour_of(style: Style) -> Color {
        style.fg.unwrap_or(Color::Reset)
    }

    /// The text as it is shown: where there is nothing but ASCII, signs that mean something are
    /// spelled out. To be asked for before a width is measured.
    pub(crate) fn spelled(self, text: impl Into<String>) -> String {
        let text = text.into();
        if !self.ascii || text.is_ascii() {
            return text;
        }
        let words = [("±", "+-"), ("τ", "tau"), ("σ", "sigma"), ("≤", "<="), ("≥", ">="), ("²", "^2"), ("÷", "/")];
        let text = words.into_iter().fold(text, |text, (sign, word)| text.replace(sign, word));
        let text = text.replace('°', "deg ");
        let mut parts = text.split('√');
        let first = parts.next().unwrap_or_default().to_owned();
        parts.fold(first, |text, part| {
            let under = part.find(|sign: char| !sign.is_alphanumeric()).unwrap_or(part.len());
            format!("{text}sqrt({}){}", &part[..under], &part[under..])
        })
    }

    /// Puts ASCII in the place of every other sign, where nothing else is shown.
    pub(crate) fn finish(self, buffer: &mut Buffer) {
        if self.ascii {
            for cell in &mut buffer.content {
                if let Some(sign) = cell.symbol().chars().next().filter(|sign| !sign.is_ascii()) {
                    cell.set_char(ascii(sign));
                }
            }
        }
    }
}

/// The sign of ASCII that looks most alike; what means something in a number or a unit has none,
/// and is to be [spelled](Theme::spelled).
fn ascii(sign: char) -> char {
    match sign {
        '─' | '━' | '–' | '┄' => '-',
        '│' | '┃' => '|',
        '┊' => ':',
        '┈' | '·' | '…' => '.',
        '●' => 'o',
        '▲' | '↑' => '^',
        '◆' => '#',
        '↓' => 'v',
        '←' | '◀' => '<',
        '→' | '▶' => '>',
        '×' => 'x',
        'µ' => 'u',
        '▁' | '▂' => '_',
        '▃' | '▄' => '-',
        '▅' | '▆' => '=',
        '▇' | '█' => '#',
        // dots of braille: the more, the darker
        '\u{2800}'..='\u{28ff}' => match (u32::from(sign) & 0xff).count_ones() {
            0 => ' ',
            1..=2 => '.',
            3..=5 => ':',
            _ => '#',
        },
        '\u{2500}'..='\u{257f}' => '+',
        _ => '?',
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn theme(variables: &[(&str, &str)]) -> Theme {
        Theme::of(|name| variables.iter().find(|(n, _)| *n == name).map(|(_, value)| (*value).to_owned()))
    }

    #[test]
    fn the_environment_says_what_a_terminal_shows() {
        for (variables, colours, ascii) in [
            (
                &[("TERM", "xterm-256color"), ("COLORTERM", "truecolor"), ("LANG", "de_AT.UTF-8")][..],
                Colours::True,
                false,
            ),
            (&[("TERM", "xterm"), ("LC_ALL", "C"), ("LANG", "de_AT.UTF-8")], Colours::Sixteen, true),
            (
                &[("TERM", "xterm"), ("NO_COLOR", "1"), ("COLORTERM", "24bit"), ("LC_CTYPE", "C.utf8")],
                Colours::None,
                false,
            ),
            (&[("TERM", "linux"), ("LANG", "en_US.UTF-8")], Colours::Sixteen, true),
            (&[("TERM", "xterm")], Colours::Sixteen, false),
        ] {
            assert_eq!(theme(variables), Theme { colours, ascii }, "{variables:?}");
        }
    }

    #[test]
    fn no_two_axes_look_alike_nor_like_a_judgement() {
        for colours in [Colours::True, Colours::Sixteen] {
            let theme = Theme { colours, ascii: true };
            let judgements = [theme.good(), theme.warning(), theme.error(), theme.faint()];
            let styles = [0, 1, 2].map(|axis| theme.axis(axis)).into_iter().chain(judgements);
            let different: std::collections::HashSet<_> = styles.map(Theme::colour_of).collect();
            assert_eq!(different.len(), 7, "{colours:?}");
        }
        let signs: std::collections::BTreeSet<_> = SIGNS.iter().flat_map(|sign| sign.chars()).map(ascii).collect();
        assert_eq!(signs.len(), 3, "nor without colours");
        let plain = Theme { colours: Colours::None, ascii: true };
        assert!((0..3).all(|axis| plain.axis(axis) == Style::new()));
    }

    #[test]
    fn every_sign_in_use_has_one_of_ascii() {
        let text: String = "─│┊┈●▲◆↑↓←→▁█⠁⣿┌".chars().map(ascii).collect();
        assert_eq!(text, "-|:.o^#^v<>_#.#+");
    }

    #[test]
    fn what_means_something_is_spelled_out() {
        let plain = Theme { colours: Colours::None, ascii: true };
        for (text, spelled) in [
            ("5.25e-3 ±1.0 % deg/s/√Hz one-sided", "5.25e-3 +-1.0 % deg/s/sqrt(Hz) one-sided"),
            ("deg/√h, m/s²/√s", "deg/sqrt(h), m/s^2/sqrt(s)"),
            ("σ(τ) falls as √τ", "sigma(tau) falls as sqrt(tau)"),
            ("K ≥ 2, B ≤ 3", "K >= 2, B <= 3"),
            ("22.7 °C", "22.7 deg C"),
            ("┌─ ● 3", "┌─ ● 3"),
        ] {
            assert_eq!(plain.spelled(text), spelled);
            assert_eq!(Theme { ascii: false, ..plain }.spelled(text), text);
        }
    }
}
