//! The frame of every page: its head, style sheet and script.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::html::elements::text_of;

const STYLE: &str = include_str!("../../assets/page.css");
const SCRIPT: &str = include_str!("../../assets/page.js");

/// A page that needs nothing else.
pub(super) struct Page<'a> {
    pub(super) title: &'a str,
    /// What it has beside the style sheet of all pages.
    pub(super) style: &'a str,
    /// Of a live page the id from which its events continue.
    pub(super) version: Option<&'a str>,
    /// What stands below its title.
    pub(super) head: Markup,
    pub(super) main: Markup,
}

impl Page<'_> {
    pub(super) fn text(self) -> String {
        let Self { title, style, version, head, main } = self;
        text_of(html! {
            (DOCTYPE)
            html lang="en" data-version=[version] {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    title { (title) }
                    @if version.is_some() { link rel="icon" href="icon.svg" type="image/svg+xml"; }
                    style { (PreEscaped(STYLE)) (PreEscaped(style)) }
                }
                body {
                    header { h1 { (title) } (head) }
                    main { (main) }
                    script { (PreEscaped(SCRIPT)) }
                }
            }
        })
    }
}
