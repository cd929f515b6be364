//! Whether a last row without a line end is whole: many writers leave the last line end out, and a
//! cut file has none either.

use super::number::Number;

/// How the last fields of rows are printed.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct LastField {
    /// `None` before the first row.
    form: Option<Form>,
}

/// What all fields have in common.
#[derive(Debug, Clone, Copy)]
struct Form {
    /// Digits behind the point, of which there must be some: a whole number cut short looks like
    /// one.
    decimals: Option<u32>,
    width: Option<usize>,
}

impl LastField {
    pub(super) fn add(&mut self, field: &[u8]) {
        let added = Form::of(field);
        let common = self.form.map_or(added, |form| Form {
            decimals: form.decimals.filter(|_| form.decimals == added.decimals),
            width: form.width.filter(|_| form.width == added.width),
        });
        self.form = Some(common);
    }

    /// Whether `field` has the decimals or the width that all others have. Where they have neither
    /// in common that is not known.
    pub(super) fn is_whole(&self, field: &[u8]) -> bool {
        let Form { decimals, width } = Form::of(field);
        self.form.is_some_and(|form| {
            form.decimals.is_some() && form.decimals == decimals || form.width.is_some() && form.width == width
        })
    }
}

impl Form {
    fn of(field: &[u8]) -> Self {
        let decimals = Number::parse(field).map(|number| number.decimals());
        Self { decimals: decimals.filter(|&decimals| decimals > 0), width: Some(field.len()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_is_whole_with_the_decimals_or_the_width_of_all_others() {
        for (others, field, whole) in [
            (&["+00.000301", "-00.000391"][..], "+00.000724", true),
            (&["+00.000301", "-00.000391"], "+00.00072", false),
            (&["0.301", "-12.391"], "7.724", true),
            (&["0.301", "-12.391"], "7.72", false),
            (&["1234", "1235"], "1236", true),
            (&["1234", "1235"], "123", false),
            (&["9", "10"], "11", false),
            (&["0.5", "0.25"], "0.125", false),
            (&["12:00:01", "12:00:02"], "12:00:03", true),
            (&["12:00:01", "12:00:02"], "12:00", false),
            (&["", ""], "", true),
            (&[], "0.5", false),
        ] {
            let mut last = LastField::default();
            others.iter().for_each(|other| last.add(other.as_bytes()));
            assert_eq!(last.is_whole(field.as_bytes()), whole, "{field} behind {others:?}");
        }
    }
}
