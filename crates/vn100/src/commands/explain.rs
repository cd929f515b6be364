//! `vn100 explain`: the glossary of results, one code or all of them.

use std::fmt::{self, Write};

use anyhow::Result;
use vn100_analysis::Completion;
use vn100_report::glossary::{Explanation, explain as explained, glossary};

use vn100_report::remedies::remedy_words;

use crate::{
    exit::{print, report},
    text::{fill, text},
};

pub(crate) fn explain(words: &[String]) -> Result<Completion> {
    if words.is_empty() {
        print(&text(write_list))?;
        return Ok(Completion::Complete);
    }
    // the words of one name, or several codes
    let mut found = explained(&words.join(" "));
    if found.is_empty() {
        for code in words {
            let of_code = explained(code);
            if of_code.is_empty() {
                report(&format!("'{code}' is no code or parameter: `vn100 explain` lists all of them"));
                return Ok(Completion::NotGiven);
            }
            found.extend(of_code);
        }
    }
    print(&text(|out| write_explanations(out, &found)))?;
    Ok(Completion::Complete)
}

fn write_explanations(out: &mut String, found: &[Explanation]) -> fmt::Result {
    for (place, entry) in found.iter().enumerate() {
        if place > 0 {
            writeln!(out)?;
        }
        let Explanation { group, code, aliases, title, meaning, why, source, .. } = entry;
        let title = if title == code { String::new() } else { format!(": {title}") };
        writeln!(out, "{}", fill(&format!("{code}{title} [{group}]"), "", "  "))?;
        let advice = entry.advice(remedy_words);
        let also = aliases.join(", ");
        for (label, text) in
            [("meaning", &**meaning), ("matters", why), ("what to do", &*advice), ("also", &*also), ("source", source)]
        {
            if !text.is_empty() {
                writeln!(out, "{}", fill(text, &format!("  {label:<11}"), "             "))?;
            }
        }
    }
    Ok(())
}

fn write_list(out: &mut String) -> fmt::Result {
    for group in glossary().chunk_by(|a, b| a.group == b.group) {
        writeln!(out, "{}", group[0].group)?;
        let codes: Vec<&str> = group.iter().map(|entry| &*entry.code).collect();
        writeln!(out, "{}", fill(&codes.join(", "), "  ", "  "))?;
    }
    writeln!(out, "\n`vn100 explain CODE` explains one of them, such as gaps, bounded or ARW")
}

#[cfg(test)]
mod tests {
    use crate::text::WIDTH;

    use super::*;

    #[test]
    fn no_line_is_wider_than_the_text() {
        let all = text(|out| write_explanations(out, &glossary())) + &text(write_list);
        let wide: Vec<&str> = all.lines().filter(|line| line.chars().count() > WIDTH).collect();
        assert!(wide.is_empty(), "{wide:?}");
    }
}
