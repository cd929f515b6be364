//! The columns of a table that are read, and the columns that are left out.

use std::cmp::Reverse;

use vn100_protocol::{Quantity, stream::LeftOutColumn};

use super::{
    HeadRows, Unusable,
    channels::{known, quantity_word, rank},
    column_map::ColumnMap,
    header::Header,
    name::{Made, Meaning},
    numbers_at, same_column,
    unit::{Unit, units},
};

/// The columns that are read, and the others whose names tell their content.
#[derive(Debug, Default)]
pub(super) struct Columns {
    /// In the order of the channels in a layout.
    pub(super) read: Vec<Column>,
    /// The places of the channels of other streams.
    pub(super) others: Vec<usize>,
    pub(super) left_out: Vec<LeftOutColumn>,
    /// Whether the columns that are read are compensated, as far as their names tell.
    pub(super) compensated: Option<bool>,
}

/// A column of a table, or a number of a message, that holds a channel.
#[derive(Debug, Clone)]
pub(crate) struct Column {
    pub(crate) place: usize,
    /// The channel, as in [`known`].
    pub(crate) channel: usize,
    pub(crate) unit: Unit,
}

impl Column {
    pub(super) fn name(&self) -> &'static str {
        &known(self.channel).name
    }
}

/// A column whose name tells its content.
struct Named {
    place: usize,
    meaning: Meaning,
    is_empty: bool,
}

impl Named {
    /// The unit, if it is known and the column has numbers.
    fn unit(&self) -> Option<&Unit> {
        match &self.meaning.unit {
            _ if self.is_empty => None,
            Some(Ok(unit)) => Some(unit),
            None if self.meaning.is_sure => units(known(self.meaning.channel).quantity).next(),
            _ => None,
        }
    }

    /// What the axes of one triple have in common.
    fn triple(&self) -> (&str, Made) {
        (&self.meaning.group, self.meaning.made)
    }

    /// The stated unit, or the one that the other axes of the triple state, if none of them is there twice.
    fn unit_of_triple(&self, named: &[Self]) -> Option<Result<Unit, String>> {
        let beside = || named.iter().filter(|other| other.triple() == self.triple()).map(|other| &other.meaning);
        let is_twice = |axis: &Meaning| {
            axis.unit.is_some() && beside().any(|other| other.channel == axis.channel && other.unit.is_none())
        };
        if self.meaning.unit.is_some() || beside().any(is_twice) {
            return self.meaning.unit.clone();
        }
        let stated = beside().filter_map(|axis| axis.unit.clone());
        stated.reduce(|unit, other| if unit == other { unit } else { Err("one of several".into()) })
    }

    /// The order of several columns of one sensor: by how they were made, a word before a letter, more
    /// axes before fewer, then by their place.
    fn rank(&self, usable: &[&Self]) -> (Made, bool, Reverse<usize>, usize) {
        let beside: Vec<&&Self> = usable.iter().filter(|other| other.triple() == self.triple()).collect();
        let mut axes: Vec<usize> = beside.iter().map(|axis| axis.meaning.channel).collect();
        axes.sort_unstable();
        axes.dedup();
        let first = beside.first().map_or(self.place, |first| first.place);
        (self.meaning.made, !self.meaning.is_sure, Reverse(axes.len()), first)
    }

    /// The reason in words why the column is not read together with `read`; `None` if a letter alone
    /// gives its meaning.
    fn left_out(&self, read: &[&Self]) -> Option<String> {
        let instead = read.iter().find(|other| other.meaning.sensor() == self.meaning.sensor());
        let (made, instead_made) = (self.meaning.made, instead.map(|other| other.meaning.made));
        Some(match &self.meaning.unit {
            Some(Err(_)) | None if !self.meaning.is_sure => return None,
            Some(Err(unit)) => format!("the unit {unit:?} is not known for it"),
            _ if self.is_empty => "empty in the first rows".into(),
            _ if made == Made::WithoutGravity && instead_made.is_some_and(|instead| instead < made) => {
                "without gravity, a column with gravity is read".into()
            }
            _ if made != Made::Uncompensated && instead_made == Some(Made::Uncompensated) => {
                "compensated, an uncompensated column is read".into()
            }
            _ => format!("another {} column is read", instead.map_or("", |other| other.meaning.sensor())),
        })
    }
}

impl Columns {
    /// The names of the columns that are searched, in words.
    pub(super) const SEARCHED: &'static str = "gyro_x gyro_y gyro_z accel_x accel_y accel_z (gyr_ and acc_ too, a unit in brackets or \
         behind the name; with them mag_ or magn_ x y z, yaw pitch roll, temperature, pressure and stamps), or stamps beside a \
         column with $VN… sentences";

    /// The columns whose names tell their content, in a file of this name. A column without a number
    /// in `rows` is left out.
    pub(super) fn by_name(header: &Header, file: Option<&str>, rows: &HeadRows) -> Self {
        let named = |place: usize| {
            let is_empty = !rows.is_empty() && numbers_at(rows, place).next().is_none();
            Some(Named { place, meaning: Meaning::of(&header.described(place), file)?, is_empty })
        };
        let mut named: Vec<Named> = (0..header.names.len()).filter_map(named).collect();
        let units: Vec<_> = named.iter().map(|column| column.unit_of_triple(&named)).collect();
        named.iter_mut().zip(units).for_each(|(column, unit)| column.meaning.unit = unit);
        // a table whose only columns are empty is read, and its rows are rejected
        let is_inertial = |column: &&Named| matches!(column.meaning.sensor(), "gyro" | "accel");
        if named.iter().filter(is_inertial).all(|column| column.unit().is_none()) {
            named.iter_mut().for_each(|column| column.is_empty = false);
        }
        let usable: Vec<&Named> = named.iter().filter(|column| column.unit().is_some()).collect();
        let mut read: Vec<&Named> = Vec::new();
        for column in &usable {
            let rivals = usable.iter().filter(|other| other.meaning.sensor() == column.meaning.sensor());
            let is_best = rivals.map(|other| other.rank(&usable)).min() == Some(column.rank(&usable));
            if is_best && read.iter().all(|other| other.meaning.channel != column.meaning.channel) {
                read.push(column);
            }
        }
        read.sort_by_key(|column| column.meaning.channel);
        let channel = |column: &&Named| {
            let unit = column.unit()?.clone();
            Some(Column { place: column.place, channel: column.meaning.channel, unit })
        };
        let left_out = named.iter().filter(|column| read.iter().all(|other| other.place != column.place));
        let left_out = left_out.filter_map(|column| {
            Some(LeftOutColumn { name: header.names[column.place].clone(), reason: column.left_out(&read)? })
        });
        Self {
            read: read.iter().filter_map(channel).collect(),
            left_out: left_out.collect(),
            compensated: compensated(read.iter().map(|column| &column.meaning)),
            ..Self::default()
        }
    }

    pub(super) fn mapped(header: &Header, map: &ColumnMap) -> Result<Self, Unusable> {
        let mut found: Vec<(&'static str, usize)> = Vec::new();
        for (channel, column) in map.columns() {
            let place = header.mapped_place(channel, column)?;
            if let Some((other, _)) = found.iter().find(|(_, taken)| *taken == place) {
                return Err(same_column(column, other, channel));
            }
            found.push((channel, place));
        }
        let column = |(mapped, &(_, place)): (&super::column_map::MappedChannel, &(_, usize))| Column {
            place,
            channel: mapped.index,
            unit: mapped.unit.clone(),
        };
        let mut read: Vec<Column> = map.channels.iter().zip(&found).map(column).collect();
        read.sort_by_key(|column| column.channel);
        let meanings: Vec<_> =
            read.iter().filter_map(|column| Meaning::of(&header.names[column.place], None)).collect();
        Ok(Self { read, compensated: compensated(meanings.iter()), ..Self::default() })
    }

    /// Whether there is a channel that only an inertial sensor has.
    pub(super) fn has_inertial_channel(&self) -> bool {
        let mut quantities = self.read.iter().map(|column| known(column.channel).quantity);
        quantities.any(|quantity| matches!(quantity, Quantity::Acceleration | Quantity::AngularRate))
    }

    /// Keeps only the channels that `stream` names, individually or by their quantity.
    pub(super) fn choose(&mut self, stream: &str) -> Result<(), Unusable> {
        let words: Vec<_> = stream.split_whitespace().collect();
        let is_of = |column: &Column, word: &str| column.name() == word || quantity_word(column.name()) == word;
        if words.is_empty() || !words.iter().all(|word| self.read.iter().any(|column| is_of(column, word))) {
            let mut found: Vec<_> = self.read.iter().map(|column| quantity_word(column.name())).collect();
            found.dedup();
            found.sort_by_key(|name| rank(name));
            return Err(Unusable::certain(format!("no columns of {stream:?}: name some of {}", found.join(", "))));
        }
        let is_chosen = |column: &Column| words.iter().any(|word| is_of(column, word));
        let (chosen, others): (Vec<_>, Vec<_>) = self.read.drain(..).partition(is_chosen);
        self.read = chosen;
        self.others = others.into_iter().map(|column| column.place).collect();
        Ok(())
    }
}

/// The compensation, as far as the names of the rates tell it.
fn compensated<'a>(meanings: impl Iterator<Item = &'a Meaning>) -> Option<bool> {
    let rates = meanings.filter(|meaning| known(meaning.channel).quantity == Quantity::AngularRate);
    let mut said = rates.map(|meaning| match meaning.made {
        Made::Uncompensated => Some(false),
        Made::Compensated => Some(true),
        Made::Unsaid | Made::WithoutGravity => None,
    });
    let first = said.next()??;
    said.all(|said| said == Some(first)).then_some(first)
}
