//! Colours and signs, by what they mean.
//!
//! Those of the axes are near the colours of Okabe and Ito (2008), distinct to nearly everyone, and
//! all have a contrast of 4.5 and more to the backgrounds that they are for; no meaning rests on
//! colour alone.

use std::env;

use ratatui::{
    buffer::Buffer,
    style::{Color, Modifier, Style},
};

/// What the user chose.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum ThemeChoice {
    /// As COLORFGBG says of the background, else dark; as many colours as the terminal shows
    #[default]
    Auto,
    /// For a dark background
    Dark,
    /// For a light background
    Light,
    /// The sixteen colours that the terminal names
    #[value(name = "16")]
    Sixteen,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Colours {
    /// 24 bits, for a dark background.
    Dark,
    /// 24 bits, for a light one.
    Light,
    /// The sixteen that every terminal names; on which background is not known.
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

/// A colour on a dark background, on a light one, and of the sixteen.
type Hue = ((u8, u8, u8), (u8, u8, u8), Color);

const AXES: [Hue; 3] = [
    ((230, 159, 0), (170, 75, 0), Color::LightBlue),
    ((86, 180, 233), (0, 92, 153), Color::LightCyan),
    ((214, 135, 178), (140, 45, 110), Color::LightMagenta),
];
const GOOD: Hue = ((0, 180, 130), (0, 110, 80), Color::Green);
const WARNING: Hue = ((240, 228, 66), (120, 95, 0), Color::Yellow);
const ERROR: Hue = ((255, 115, 85), (190, 0, 30), Color::LightRed);
const FAINT: Hue = ((150, 150, 150), (100, 100, 100), Color::Reset);

/// Whether a background is light, by the variable that some terminals set, such as `15;0`: the last
/// number is that of the background among the sixteen colours.
fn is_light(variable: &str) -> bool {
    let background = variable.rsplit(';').next().and_then(|colour| colour.parse().ok());
    background.is_some_and(|colour: u8| matches!(colour, 7 | 9..=15))
}

impl Theme {
    /// The theme of a choice, by what the environment says of the terminal.
    pub(crate) fn of_terminal(choice: ThemeChoice) -> Self {
        Self::of(choice, |name| env::var(name).ok().filter(|value| !value.is_empty()))
    }

    fn of(choice: ThemeChoice, variable: impl Fn(&str) -> Option<String>) -> Self {
        let terminal = variable("TERM").unwrap_or_default();
        let true_colour = variable("COLORTERM").is_some_and(|value| value == "truecolor" || value == "24bit");
        let colours = match (variable("NO_COLOR"), choice) {
            (Some(_), _) => Colours::None,
            (None, ThemeChoice::Dark) => Colours::Dark,
            (None, ThemeChoice::Light) => Colours::Light,
            (None, ThemeChoice::Auto) if true_colour => {
                if variable("COLORFGBG").is_some_and(|text| is_light(&text)) {
                    Colours::Light
                } else {
                    Colours::Dark
                }
            }
            (None, ThemeChoice::Auto | ThemeChoice::Sixteen) => Colours::Sixteen,
        };
        let locale = ["LC_ALL", "LC_CTYPE", "LANG"].into_iter().find_map(variable);
        let other_locale = locale.is_some_and(|locale| !locale.to_lowercase().replace('-', "").contains("utf8"));
        // a console without a desktop has few signs in its font
        let ascii = other_locale || terminal == "linux" || terminal.starts_with("vt");
        Self { colours, ascii }
    }

    fn colour(self, (dark, light, nearest): Hue) -> Style {
        let exact = |(red, green, blue)| Style::new().fg(Color::Rgb(red, green, blue));
        match self.colours {
            Colours::Dark => exact(dark),
            Colours::Light => exact(light),
            Colours::Sixteen if nearest == Color::Reset => Style::new(),
            Colours::Sixteen => Style::new().fg(nearest),
            Colours::None => Style::new(),
        }
    }

    /// Of the first, second or third axis, unlike that of a judgement; of anything else no colour.
    pub(crate) fn axis(self, axis: usize) -> Style {
        AXES.get(axis).map_or(Style::new(), |hue| self.colour(*hue))
    }

    pub(crate) fn good(self) -> Style {
        self.colour(GOOD)
    }

    pub(crate) fn warning(self) -> Style {
        self.colour(WARNING).add_modifier(Modifier::BOLD)
    }

    pub(crate) fn error(self) -> Style {
        match self.colours {
            Colours::None => Style::new().add_modifier(Modifier::REVERSED),
            _ => self.colour(ERROR).add_modifier(Modifier::BOLD),
        }
    }

    /// Beside what matters: grids, frames, labels. Of the sixteen colours the gray ones are not
    /// seen on every background.
    pub(crate) fn faint(self) -> Style {
        match self.colours {
            Colours::Dark | Colours::Light => self.colour(FAINT),
            Colours::Sixteen | Colours::None => Style::new().add_modifier(Modifier::DIM),
        }
    }

    pub(crate) fn chosen(self) -> Style {
        Style::new().add_modifier(Modifier::REVERSED)
    }

    /// The colour itself, for what takes no style.
    pub(crate) fn colour_of(style: Style) -> Color {
        style.fg.unwrap_or(Color::Reset)
    }

    /// The text as it is shown: if there is nothing but ASCII, signs that mean something are
    /// spelled out. To be asked for before a width is measured.
    pub(crate) fn spelled(self, text: impl Into<String>) -> String {
        let text = text.into();
        if !self.ascii || text.is_ascii() {
            return text;
        }
        let words = [
            ("±", "+-"),
            ("τ", "tau"),
            ("σ", "sigma"),
            ("≤", "<="),
            ("≥", ">="),
            ("²", "^2"),
            ("−", "-"),
            ("½", "1/2"),
        ];
        let text = words.into_iter().fold(text, |text, (sign, word)| text.replace(sign, word));
        let text = text.replace('°', "deg ");
        let mut parts = text.split('√');
        let first = parts.next().unwrap_or_default().to_owned();
        parts.fold(first, |text, part| {
            let under = part.find(|sign: char| !sign.is_alphanumeric()).unwrap_or(part.len());
            format!("{text}sqrt({}){}", &part[..under], &part[under..])
        })
    }

    /// Puts ASCII in the place of every other sign, if nothing else is shown.
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
        '●' | '○' => 'o',
        '◇' => '+',
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

    fn theme(choice: ThemeChoice, variables: &[(&str, &str)]) -> Theme {
        Theme::of(choice, |name| variables.iter().find(|(n, _)| *n == name).map(|(_, value)| (*value).to_owned()))
    }

    #[test]
    fn the_environment_says_what_a_terminal_shows() {
        let true_colour = ("COLORTERM", "truecolor");
        for (variables, colours, ascii) in [
            (&[("TERM", "xterm-256color"), true_colour, ("LANG", "de_AT.UTF-8")][..], Colours::Dark, false),
            (&[("TERM", "xterm"), true_colour, ("COLORFGBG", "0;15")], Colours::Light, false),
            (&[("TERM", "xterm"), true_colour, ("COLORFGBG", "0;default;15")], Colours::Light, false),
            (&[("TERM", "xterm"), true_colour, ("COLORFGBG", "15;0")], Colours::Dark, false),
            (&[("TERM", "xterm"), true_colour, ("COLORFGBG", "0;8")], Colours::Dark, false),
            (&[("TERM", "xterm"), true_colour, ("COLORFGBG", "default;default")], Colours::Dark, false),
            (&[("TERM", "xterm"), ("LC_ALL", "C"), ("LANG", "de_AT.UTF-8")], Colours::Sixteen, true),
            (
                &[("TERM", "xterm"), ("NO_COLOR", "1"), ("COLORTERM", "24bit"), ("LC_CTYPE", "C.utf8")],
                Colours::None,
                false,
            ),
            (&[("TERM", "linux"), ("LANG", "en_US.UTF-8")], Colours::Sixteen, true),
            (&[("TERM", "xterm")], Colours::Sixteen, false),
        ] {
            assert_eq!(theme(ThemeChoice::Auto, variables), Theme { colours, ascii }, "{variables:?}");
        }
    }

    #[test]
    fn a_theme_is_chosen_unless_there_shall_be_no_colour() {
        for (choice, colours) in [
            (ThemeChoice::Dark, Colours::Dark),
            (ThemeChoice::Light, Colours::Light),
            (ThemeChoice::Sixteen, Colours::Sixteen),
        ] {
            let asked = [("TERM", "xterm"), ("COLORTERM", "truecolor"), ("COLORFGBG", "15;0")];
            assert_eq!(theme(choice, &asked), Theme { colours, ascii: false });
            assert_eq!(theme(choice, &[("NO_COLOR", "1")]).colours, Colours::None);
        }
    }

    fn luminance((red, green, blue): (u8, u8, u8)) -> f64 {
        let part = |value: u8| {
            let value = f64::from(value) / 255.0;
            if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * part(red) + 0.7152 * part(green) + 0.0722 * part(blue)
    }

    #[test]
    fn every_colour_is_read_on_the_backgrounds_that_it_is_for() {
        let black_and_dark = [(0, 0, 0), (30, 30, 30), (40, 42, 54), (0, 43, 54)];
        let white_and_light = [(255, 255, 255), (253, 246, 227), (250, 250, 250)];
        for (colours, backgrounds) in [(Colours::Dark, &black_and_dark[..]), (Colours::Light, &white_and_light)] {
            let theme = Theme { colours, ascii: false };
            let axes = [0, 1, 2].map(|axis| theme.axis(axis));
            let all = axes.into_iter().chain([theme.good(), theme.warning(), theme.error(), theme.faint()]);
            for style in all {
                let Color::Rgb(red, green, blue) = Theme::colour_of(style) else { panic!("{style:?}") };
                for background in backgrounds {
                    let (a, b) = (luminance((red, green, blue)), luminance(*background));
                    let contrast = (a.max(b) + 0.05) / (a.min(b) + 0.05);
                    // reversed it is the same
                    assert!(contrast >= 4.5, "{style:?} on {background:?}: {contrast:.2}");
                }
            }
        }
    }

    #[test]
    fn no_two_axes_look_alike_nor_like_a_judgement() {
        for colours in [Colours::Dark, Colours::Light, Colours::Sixteen] {
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
    fn of_the_sixteen_colours_no_gray_is_used() {
        let theme = Theme { colours: Colours::Sixteen, ascii: false };
        let axes = [0, 1, 2].map(|axis| theme.axis(axis));
        for style in axes.into_iter().chain([theme.good(), theme.warning(), theme.error(), theme.faint()]) {
            let grays = [Color::Black, Color::DarkGray, Color::Gray, Color::White];
            assert!(!grays.contains(&Theme::colour_of(style)), "{style:?}");
        }
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
