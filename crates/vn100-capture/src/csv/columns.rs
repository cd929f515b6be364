//! The columns of a table that are read, and the columns that are left out.

use std::cmp::Reverse;

use vn100_protocol::{
    Quantity,
    stream::{LeftOutColumn, LeftOutReason},
};

use super::{
    CsvError, HeadRows,
    channels::{Unit, known, quantity_word, rank, units},
    column_map::ColumnMap,
    header::Header,
    holds_number,
    name::{Made, Meaning},
};

/// The columns that are read, and the others whose names tell their content.
#[derive(Debug, Default)]
pub(super) struct Columns {
    /// In the order of the channels in a layout.
    pub(super) channels: Vec<ChannelColumn>,
    /// The places of the channels of other streams.
    pub(super) others: Vec<usize>,
    pub(super) left_out: Vec<LeftOutColumn>,
    /// Whether the columns that are read are compensated, as far as their names tell.
    pub(super) compensated: Option<bool>,
}

#[derive(Debug, Clone)]
pub(super) struct ChannelColumn {
    pub(super) place: usize,
    /// The channel, as in [`known`].
    pub(super) channel: usize,
    pub(super) unit: Unit,
}

/// A column whose name tells its content.
struct Named {
    place: usize,
    meaning: Meaning,
    is_empty: bool,
}

/// The order of several columns of one sensor: by how they were made, a word before a letter, more
/// axes before fewer, then by their place.
type Rank = (Made, bool, Reverse<usize>, usize);

impl Named {
    /// The unit, if it is known and the column has numbers.
    fn unit(&self) -> Option<&'static Unit> {
        match self.meaning.unit {
            _ if self.is_empty => None,
            Some(Ok(unit)) => Some(unit),
            None if self.meaning.is_sure => units(known(self.meaning.channel).quantity).next(),
            _ => None,
        }
    }

    fn sensor(&self) -> &'static str {
        quantity_word(&known(self.meaning.channel).name)
    }

    fn rank(&self, usable: &[&Self]) -> Rank {
        let is_beside =
            |other: &&&Self| (&other.meaning.group, other.meaning.made) == (&self.meaning.group, self.meaning.made);
        let mut axes: Vec<_> = usable.iter().filter(is_beside).collect();
        let first = axes.first().map_or(self.place, |first| first.place);
        axes.sort_by_key(|axis| axis.meaning.channel);
        axes.dedup_by_key(|axis| axis.meaning.channel);
        (self.meaning.made, !self.meaning.is_sure, Reverse(axes.len()), first)
    }

    /// The reason why the column is not read together with `read`; `None` if a letter alone gives
    /// its meaning.
    fn left_out(&self, read: &[&Self]) -> Option<LeftOutReason> {
        let instead = read.iter().find(|other| other.sensor() == self.sensor());
        let (made, instead_made) = (self.meaning.made, instead.map(|other| other.meaning.made));
        Some(match &self.meaning.unit {
            Some(Err(_)) | None if !self.meaning.is_sure => return None,
            Some(Err(unit)) => LeftOutReason::UnknownUnit(unit.clone()),
            _ if self.is_empty => LeftOutReason::Empty,
            _ if made == Made::WithoutGravity && instead_made < Some(made) && instead.is_some() => {
                LeftOutReason::WithoutGravity
            }
            _ if made != Made::Uncompensated && instead_made == Some(Made::Uncompensated) => LeftOutReason::Compensated,
            _ => LeftOutReason::AnotherOf(instead.map_or("", |other| other.sensor()).into()),
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
        let mut named: Vec<Named> = (0..header.names.len())
            .filter_map(|place| {
                let is_empty = !rows.is_empty() && !rows.iter().any(|row| holds_number(row, place));
                Some(Named { place, meaning: Meaning::of(&header.described(place), file)?, is_empty })
            })
            .collect();
        // a table whose only columns are empty is read, and its rows are rejected
        let is_inertial = |column: &&Named| matches!(column.sensor(), "gyro" | "accel");
        if named.iter().filter(is_inertial).all(|column| column.unit().is_none()) {
            named.iter_mut().for_each(|column| column.is_empty = false);
        }
        let usable: Vec<&Named> = named.iter().filter(|column| column.unit().is_some()).collect();
        let mut read: Vec<&Named> = Vec::new();
        for column in &usable {
            let rivals = usable.iter().filter(|other| other.sensor() == column.sensor());
            let is_best = rivals.map(|other| other.rank(&usable)).min() == Some(column.rank(&usable));
            if is_best && read.iter().all(|other| other.meaning.channel != column.meaning.channel) {
                read.push(column);
            }
        }
        read.sort_by_key(|column| column.meaning.channel);
        let channel = |column: &&Named| {
            let unit = column.unit()?.clone();
            Some(ChannelColumn { place: column.place, channel: column.meaning.channel, unit })
        };
        let left_out = named.iter().filter(|column| read.iter().all(|other| other.place != column.place));
        let left_out = left_out.filter_map(|column| {
            Some(LeftOutColumn { name: header.names[column.place].clone(), reason: column.left_out(&read)? })
        });
        Self {
            channels: read.iter().filter_map(channel).collect(),
            left_out: left_out.collect(),
            compensated: compensated(read.iter().map(|column| &column.meaning)),
            ..Self::default()
        }
    }

    /// The columns that `map` names.
    pub(super) fn mapped(header: &Header, map: &ColumnMap) -> Result<Self, CsvError> {
        let mut found: Vec<(&'static str, usize)> = Vec::new();
        for (channel, column) in map.columns() {
            let place = header.mapped_place(channel, column)?;
            if let Some((other, _)) = found.iter().find(|(_, taken)| *taken == place) {
                return Err(CsvError::same_column(&column.to_string(), other, channel));
            }
            found.push((channel, place));
        }
        let channels = map.channels.iter().zip(&found);
        let mut channels: Vec<ChannelColumn> = channels
            .map(|(mapped, &(_, place))| ChannelColumn { place, channel: mapped.index, unit: mapped.unit.clone() })
            .collect();
        channels.sort_by_key(|column| column.channel);
        let meanings: Vec<_> =
            channels.iter().filter_map(|column| Meaning::of(&header.names[column.place], None)).collect();
        Ok(Self { channels, compensated: compensated(meanings.iter()), ..Self::default() })
    }

    /// Whether there is a channel that only an inertial sensor has.
    pub(super) fn has_inertial_channel(&self) -> bool {
        let mut quantities = self.channels.iter().map(|column| known(column.channel).quantity);
        quantities.any(|quantity| matches!(quantity, Quantity::Acceleration | Quantity::AngularRate))
    }

    /// Keeps only the channels that `stream` names, individually or by their quantity.
    pub(super) fn choose(&mut self, stream: &str) -> Result<(), CsvError> {
        let words: Vec<_> = stream.split_whitespace().collect();
        let is_of = |column: &ChannelColumn, word: &str| {
            let name = &*known(column.channel).name;
            name == word || quantity_word(name) == word
        };
        let is_there = |word: &&str| self.channels.iter().any(|column| is_of(column, word));
        if words.is_empty() || !words.iter().all(is_there) {
            let mut found: Vec<_> =
                self.channels.iter().map(|column| quantity_word(&known(column.channel).name)).collect();
            found.dedup();
            found.sort_by_key(|name| rank(name));
            return Err(CsvError::certain(format!("no columns of {stream:?}: name some of {}", found.join(", "))));
        }
        let is_chosen = |column: &ChannelColumn| words.iter().any(|word| is_of(column, word));
        let (chosen, others): (Vec<_>, Vec<_>) = self.channels.iter().cloned().partition(is_chosen);
        self.channels = chosen;
        self.others = others.into_iter().map(|column| column.place).collect();
        Ok(())
    }
}

/// The compensation, as far as the names of the rates tell it.
fn compensated<'a>(meanings: impl Iterator<Item = &'a Meaning>) -> Option<bool> {
    let inertial = meanings.filter(|meaning| known(meaning.channel).quantity == Quantity::AngularRate);
    let mut said = inertial.map(|meaning| match meaning.made {
        Made::Uncompensated => Some(false),
        Made::Compensated => Some(true),
        Made::Unsaid | Made::WithoutGravity => None,
    });
    let first = said.next()??;
    said.all(|said| said == Some(first)).then_some(first)
}
