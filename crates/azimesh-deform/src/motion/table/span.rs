//! Values over azimuth, time or step at every station of a blade.

use super::{Column, History, Interpolation, Key, Table};
use azimesh_core::error::Result;
use std::cmp::Ordering;
use std::ops::Range;

/// Largest number of values if every azimuth has its own stations.
const MOST: usize = 1 << 26;

/// Values over azimuth and station: linear between stations, held past the first and last.
#[derive(Debug, Clone)]
pub struct SpanHistory {
    stations: Vec<f64>,
    /// The first line that has each of them.
    lines: Vec<u64>,
    /// Values in a row of the table.
    n_values: usize,
    /// Each row holds all stations.
    history: History,
}

/// The values of all stations at one azimuth, with their rates.
#[derive(Debug, Clone)]
pub struct SpanValues<'a> {
    stations: &'a [f64],
    n_values: usize,
    /// (stations, n), by rows.
    values: Vec<f64>,
    rates: Vec<f64>,
}

impl SpanHistory {
    /// Creates it from columns of a table with a row for each azimuth and station, in any order. If stations differ
    /// between azimuths, values are first interpolated along the stations. Without a key there is one set of stations,
    /// which holds everywhere.
    pub fn from_table(
        table: &Table,
        key: Option<(Key, Column)>,
        station: Column,
        columns: &[Option<Column>],
        interpolation: Interpolation,
    ) -> Result<Self> {
        let rows = Rows {
            table,
            key,
            station,
            columns,
        };
        let (order, groups) = rows.groups()?;
        let placed = order
            .iter()
            .map(|&row| (rows.station(row), table.line(row)));
        let mut placed: Vec<(f64, u64)> = placed.collect();
        placed.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        placed.dedup_by_key(|(station, _)| *station);
        let (stations, lines): (Vec<f64>, Vec<u64>) = placed.into_iter().unzip();
        if groups.iter().any(|group| group.len() < stations.len()) {
            rows.check_complete(&order, &groups)?;
        }
        let n = columns.len();
        let (size, name) = (stations.len() * n, key.unwrap_or((Key::Step, station)).0);
        if size.saturating_mul(groups.len()) > MOST {
            return Err(table.header_error(format!(
                "{} azimuths have {} different stations between them, too many to keep; give all azimuths the same stations",
                groups.len(),
                stations.len()
            )));
        }
        let mut values = Vec::with_capacity(size * groups.len());
        for group in &groups {
            rows.resample(&order[group.clone()], &stations, &mut values);
        }
        let knots = groups.iter().map(|group| rows.key(order[group.start]));
        let history = History::new(table.path(), name, knots.collect(), values, interpolation);
        let ends = [&groups[0], &groups[groups.len() - 1]];
        let history = history.with_lines(ends.map(|group| table.line(order[group.start])));
        let history = match key {
            Some(_) => history.held(),
            None => history,
        };
        Ok(Self {
            stations,
            lines,
            n_values: n,
            history,
        })
    }

    /// Returns all stations of all azimuths, increasing.
    pub fn stations(&self) -> &[f64] {
        &self.stations
    }

    /// Returns the first line of the table that has a station, by its index.
    pub fn line(&self, station: usize) -> u64 {
        self.lines[station]
    }

    /// Interpolation over azimuth: a row holds the values of all stations.
    pub fn history(&self) -> &History {
        &self.history
    }

    /// Returns values and rates of all stations at a position in the unit of the key.
    pub fn at(&self, at: f64) -> Result<SpanValues<'_>> {
        Ok(SpanValues {
            stations: &self.stations,
            n_values: self.n_values,
            values: self.history.at(at)?,
            rates: self.history.rates_at(at)?,
        })
    }
}

impl SpanValues<'_> {
    /// Returns the first `N` values at a station.
    #[inline]
    pub fn values<const N: usize>(&self, station: f64) -> [f64; N] {
        self.between(&self.values, station)
    }

    /// Returns their derivatives with respect to the key, in its unit.
    pub fn rates<const N: usize>(&self, station: f64) -> [f64; N] {
        self.between(&self.rates, station)
    }

    #[inline]
    fn between<const N: usize>(&self, of: &[f64], station: f64) -> [f64; N] {
        let (lower, upper, part) = between(self.stations.len(), |i| self.stations[i], station);
        let row = |i: usize| &of[i * self.n_values..][..N];
        let (lower, upper) = (row(lower), row(upper));
        let mut row = [0.0; N];
        for c in 0..N {
            row[c] = (1.0 - part) * lower[c] + part * upper[c];
        }
        row
    }
}

/// Returns the increasing positions before and after `at`, and its fraction between them; the same position twice
/// beyond the ends.
#[inline]
fn between(n: usize, place: impl Fn(usize) -> f64, at: f64) -> (usize, usize, f64) {
    let (mut low, mut high) = (0, n);
    while low < high {
        let middle = (low + high) / 2;
        if place(middle) <= at {
            low = middle + 1
        } else {
            high = middle
        }
    }
    if low == 0 || low == n {
        let end = low.saturating_sub(1);
        return (end, end, 0.0);
    }
    let (before, after) = (place(low - 1), place(low));
    (low - 1, low, (at - before) / (after - before))
}

/// The table by its columns.
struct Rows<'a> {
    table: &'a Table,
    key: Option<(Key, Column)>,
    station: Column,
    /// Columns that are left out are 0.
    columns: &'a [Option<Column>],
}

impl Rows<'_> {
    fn key(&self, row: usize) -> f64 {
        self.key
            .map_or(0.0, |(_, column)| self.table.value(row, column))
    }

    fn station(&self, row: usize) -> f64 {
        self.table.value(row, self.station)
    }

    fn place(&self, row: usize) -> String {
        let station = self.station(row);
        match self.key {
            Some((key, _)) => format!("{}, station {station}", key.place(self.key(row))),
            None => format!("station {station}"),
        }
    }

    /// Sorts rows by azimuth and station; returns the order and the range of each azimuth.
    fn groups(&self) -> Result<(Vec<usize>, Vec<Range<usize>>)> {
        let by_place = |a: &usize, b: &usize| {
            let by_key = self.key(*a).total_cmp(&self.key(*b));
            by_key.then(self.station(*a).total_cmp(&self.station(*b)))
        };
        let mut order: Vec<usize> = (0..self.table.n_rows()).collect();
        order.sort_by(by_place);
        let repeated = order.windows(2).filter(|pair| self.are_same(pair));
        if let Some(pair) = repeated.min_by_key(|pair| pair[1]) {
            let message = format!(
                "{} is given twice, first in line {}; keep one of the rows",
                self.place(pair[1]),
                self.table.line(pair[0])
            );
            return Err(self.table.error(pair[1], message));
        }
        let mut groups: Vec<Range<usize>> = Vec::new();
        for (at, &row) in order.iter().enumerate() {
            match groups.last_mut() {
                Some(group) if self.key(order[group.start]) == self.key(row) => group.end = at + 1,
                _ => groups.push(at..at + 1),
            }
        }
        Ok((order, groups))
    }

    fn are_same(&self, pair: &[usize]) -> bool {
        self.key(pair[0]) == self.key(pair[1]) && self.station(pair[0]) == self.station(pair[1])
    }

    /// Refuses an azimuth whose stations are only some of the stations of the azimuth with most: rows are missing there.
    fn check_complete(&self, order: &[usize], groups: &[Range<usize>]) -> Result<()> {
        let largest = groups.iter().map(ExactSizeIterator::len).max();
        let fullest = groups.iter().find(|group| Some(group.len()) == largest);
        let fullest = &order[fullest.expect("a table has rows").clone()];
        for group in groups {
            let group = &order[group.clone()];
            if group.len() == fullest.len() {
                continue;
            }
            let is_in = |row: usize, rows: &[usize]| {
                let find = |other: &usize| -> Ordering {
                    self.station(*other).total_cmp(&self.station(row))
                };
                rows.binary_search_by(find).is_ok()
            };
            if group.iter().all(|&row| is_in(row, fullest)) {
                let missing = fullest.iter().find(|&&row| !is_in(row, group));
                let missing = *missing.expect("it has fewer stations");
                let (key, _) = self.key.expect("without a key there is one group");
                let message = format!(
                    "{} has no row for station {}, which {} has in line {}; add it",
                    key.place(self.key(group[0])),
                    self.station(missing),
                    key.place(self.key(missing)),
                    self.table.line(missing)
                );
                let last = group.iter().copied().max();
                return Err(self.table.error(last.expect("it has rows"), message));
            }
        }
        Ok(())
    }

    /// Returns the values of one azimuth at all stations, interpolated linearly.
    fn resample(&self, group: &[usize], stations: &[f64], values: &mut Vec<f64>) {
        for station in stations {
            let (lower, upper, part) = between(group.len(), |i| self.station(group[i]), *station);
            let (lower, upper) = (group[lower], group[upper]);
            values.extend(self.columns.iter().map(|column| {
                let value = |row| column.map_or(0.0, |column| self.table.value(row, column));
                (1.0 - part) * value(lower) + part * value(upper)
            }));
        }
    }
}
