//! Tables of an SQLite file, read row by row in the order of their row numbers.
//!
//! Only the scan of a table is implemented: no index, no write-ahead log, no query. The format:
//! <https://www.sqlite.org/fileformat2.html>.

use std::{
    io::{self, ErrorKind, Read, Seek, SeekFrom},
    ops::Range,
};

pub(super) const MAGIC: &[u8] = b"SQLite format 3\0";

/// Bytes of one read of the file: neighbouring pages follow each other.
const BLOCK_BYTES: usize = 256 * 1024;

/// Longest row that is read.
const ROW_BYTES: u64 = 4 * 1024 * 1024 + 4096;

const FILE_HEADER_BYTES: usize = 100;

/// The kind of a page with rows of a table.
const LEAF: u8 = 0x0d;

pub(super) struct Database<R> {
    file: R,
    page_bytes: usize,
    /// Usable bytes of each page.
    usable_bytes: usize,
    pages: u64,
    /// A part of the file, with its offset.
    block: Vec<u8>,
    block_start: u64,
    /// Overflow pages read in this scan: a table has each of them once.
    overflow_pages: u64,
}

/// A table, as the schema names it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SqliteTable {
    pub(super) name: String,
    pub(super) columns: Vec<String>,
    /// Its first page.
    pub(super) root: u32,
}

impl SqliteTable {
    pub(super) fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }
}

/// The position of a scan in a table.
#[derive(Debug)]
pub(super) struct TableScan {
    /// The pages that come later; the last is the next.
    pages: Vec<u32>,
    leaf: Vec<u8>,
    cells: Range<usize>,
    cells_at: usize,
    pages_read: u64,
    /// The error at a page that is not in the file: the leaves before a cut follow, whose branches may lie behind it.
    cut: Option<io::Error>,
}

/// A row: its number, and the requested part of its bytes.
#[derive(Debug, Default)]
pub(super) struct Row {
    pub(super) id: i64,
    bytes: Vec<u8>,
    /// Length of the row, in its leaf and on overflow pages.
    total_bytes: u64,
    overflow_page: u32,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum SqlValue<'a> {
    Integer(i64),
    Text(&'a [u8]),
    Blob(&'a [u8]),
    /// Nothing, a float, or a field whose bytes were not read.
    Other,
}

impl<R: Read + Seek> Database<R> {
    pub(super) fn open(mut file: R) -> io::Result<Self> {
        let bytes = file.seek(SeekFrom::End(0))?;
        file.seek(SeekFrom::Start(0))?;
        let mut header = [0; FILE_HEADER_BYTES];
        file.read_exact(&mut header)?;
        let page_bytes = match u16::from_be_bytes([header[16], header[17]]) {
            1 => 65_536,
            bytes => usize::from(bytes),
        };
        let usable_bytes = page_bytes.saturating_sub(header[20].into());
        if !header.starts_with(MAGIC) || !page_bytes.is_power_of_two() || usable_bytes < 480 {
            return Err(damaged(&format!("pages of {page_bytes} bytes, {usable_bytes} of them used")));
        }
        let pages = bytes / page_bytes as u64;
        Ok(Self { file, page_bytes, usable_bytes, pages, block: Vec::new(), block_start: 0, overflow_pages: 0 })
    }

    pub(super) fn tables(&mut self) -> io::Result<Vec<SqliteTable>> {
        const MOST_TABLES: usize = 10_000;
        let mut tables = Vec::new();
        self.each_row(1, |row| {
            let field = |place| row.field(place);
            let text = |value| if let SqlValue::Text(text) = value { String::from_utf8_lossy(text) } else { "".into() };
            if text(field(0)) == "table"
                && let SqlValue::Integer(root) = field(3)
                && let Ok(root) = u32::try_from(root)
            {
                let columns = column_names(&text(field(4)));
                tables.push(SqliteTable { name: text(field(1)).into_owned(), columns, root });
            }
            if tables.len() > MOST_TABLES { Err(damaged(&format!("more than {MOST_TABLES} tables"))) } else { Ok(()) }
        })?;
        Ok(tables)
    }

    /// Shows all rows of the table with this first page.
    pub(super) fn each_row(&mut self, root: u32, mut show: impl FnMut(&Row) -> io::Result<()>) -> io::Result<()> {
        let (mut scan, mut row) = (self.scan(root), Row::default());
        while self.next_row(&mut scan, &mut row)? {
            self.complete(&mut row)?;
            show(&row)?;
        }
        Ok(())
    }

    /// A scan of the table with this first page, from its first row on.
    pub(super) fn scan(&mut self, root: u32) -> TableScan {
        self.overflow_pages = 0;
        let (pages, leaf) = (vec![root], Vec::new());
        TableScan { pages, leaf, cells: 0..0, cells_at: 0, pages_read: 0, cut: None }
    }

    /// Reads the part of the next row that is in its leaf; `false` after the last row. Of a table whose branches
    /// were cut off, all rows of other tables are among those that follow, and the error is after them.
    pub(super) fn next_row(&mut self, scan: &mut TableScan, row: &mut Row) -> io::Result<bool> {
        while scan.cells.is_empty() {
            if !self.enter_next(scan)? {
                return Ok(false);
            }
        }
        let Some(cell) = scan.cells.next() else { return Ok(false) };
        let at = cell_offset(&scan.leaf, scan.cells_at, cell)?;
        let cell = scan.leaf.get(at..).ok_or_else(|| damaged("a cell lies outside of its page"))?;
        let (total_bytes, rest) = varint(cell)?;
        let (id, rest) = varint(rest)?;
        let local = self.local_bytes(total_bytes);
        let (bytes, rest) = rest.split_at_checked(local).ok_or_else(|| damaged("a row ends outside of its page"))?;
        row.id = id as i64;
        row.total_bytes = total_bytes;
        row.bytes.clear();
        row.bytes.extend_from_slice(bytes);
        row.overflow_page = if total_bytes > local as u64 { number_4(rest, 0)? } else { 0 };
        Ok(true)
    }

    /// Goes to the next page; `false` after the last one.
    fn enter_next(&mut self, scan: &mut TableScan) -> io::Result<bool> {
        let Some(page) = scan.pages.pop() else { return scan.cut.take().map_or(Ok(false), Err) };
        match self.enter(scan, page) {
            Err(error) if u64::from(page) > self.pages && scan.cut.is_none() => {
                (scan.pages, scan.pages_read) = (self.leaves()?, 0);
                scan.cut = Some(error);
            }
            entered => entered?,
        }
        Ok(true)
    }

    /// All pages with rows of tables, in the order of their first rows, the last one first.
    fn leaves(&mut self) -> io::Result<Vec<u32>> {
        let mut leaves = Vec::new();
        for number in 2..=self.pages as u32 {
            let leaf = self.page(number)?;
            if leaf[0] != LEAF {
                continue;
            }
            let first = cell_offset(leaf, 8, 0).ok().and_then(|at| leaf.get(at..));
            if let Some(Ok((_, rest))) = first.map(varint)
                && let Ok((id, _)) = varint(rest)
            {
                leaves.push((id as i64, number));
            }
        }
        leaves.sort_unstable_by(|a, b| b.cmp(a));
        Ok(leaves.into_iter().map(|(_, number)| number).collect())
    }

    /// Reads the part of the row on overflow pages, unless the row is longer than any message: then
    /// its last fields remain [`SqlValue::Other`].
    pub(super) fn complete(&mut self, row: &mut Row) -> io::Result<()> {
        if row.total_bytes > ROW_BYTES {
            return Ok(());
        }
        while row.overflow_page != 0 && (row.bytes.len() as u64) < row.total_bytes {
            self.overflow_pages += 1;
            if self.overflow_pages > self.pages {
                return Err(damaged("rows share the pages that they continue on"));
            }
            let left = (row.total_bytes - row.bytes.len() as u64) as usize;
            let usable_bytes = self.usable_bytes;
            let page = self.page(row.overflow_page)?;
            let next = number_4(page, 0)?;
            let take = left.min(usable_bytes - 4);
            row.bytes.extend_from_slice(&page[4..4 + take]);
            row.overflow_page = next;
        }
        if (row.bytes.len() as u64) < row.total_bytes { Err(damaged("a row ends before its length")) } else { Ok(()) }
    }

    /// Goes to the rows of a page, or puts the pages below it first.
    fn enter(&mut self, scan: &mut TableScan, number: u32) -> io::Result<()> {
        const INTERIOR: u8 = 0x05;
        scan.pages_read += 1;
        // the branches on the way to a leaf take fewer bytes than a page; those of a cut file may
        // outnumber its pages
        if scan.pages_read > self.pages || scan.cut.is_none() && scan.pages.len() > self.page_bytes {
            return Err(damaged("a page of a table is its own branch"));
        }
        let header = if number == 1 { FILE_HEADER_BYTES } else { 0 };
        let page = self.page(number)?;
        let cells = usize::from(u16::from_be_bytes([page[header + 3], page[header + 4]]));
        match page[header] {
            LEAF => {
                scan.leaf.clear();
                scan.leaf.extend_from_slice(page);
                (scan.cells, scan.cells_at) = (0..cells, header + 8);
            }
            INTERIOR => {
                scan.pages.push(number_4(page, header + 8)?);
                // a damaged number is an error once the pages before it are read
                let below = |cell| number_4(page, cell_offset(page, header + 12, cell)?);
                scan.pages.extend((0..cells).rev().map(|cell| below(cell).unwrap_or(0)));
            }
            other => return Err(damaged(&format!("page {number} has the kind {other:#04x}, not that of a table"))),
        }
        Ok(())
    }

    /// The number of bytes of a row in its leaf.
    fn local_bytes(&self, total_bytes: u64) -> usize {
        let usable = self.usable_bytes;
        let most = usable - 35;
        if total_bytes <= most as u64 {
            return total_bytes as usize;
        }
        let least = (usable - 12) * 32 / 255 - 23;
        let local = least + ((total_bytes - least as u64) % (usable as u64 - 4)) as usize;
        if local <= most { local } else { least }
    }

    fn page(&mut self, number: u32) -> io::Result<&[u8]> {
        let number = u64::from(number);
        if number == 0 || number > self.pages {
            return Err(damaged(&format!("it refers to page {number}, and {} are there", self.pages)));
        }
        let at = (number - 1) * self.page_bytes as u64;
        let is_held = |at: u64| {
            let offset = at.checked_sub(self.block_start)?;
            let end = usize::try_from(offset).ok()?.checked_add(self.page_bytes)?;
            (end <= self.block.len()).then_some(offset as usize)
        };
        let offset = match is_held(at) {
            Some(offset) => offset,
            None => {
                self.file.seek(SeekFrom::Start(at))?;
                self.block.clear();
                self.file.by_ref().take(BLOCK_BYTES as u64).read_to_end(&mut self.block)?;
                self.block_start = at;
                if self.block.len() < self.page_bytes {
                    return Err(damaged("it was cut inside a page"));
                }
                0
            }
        };
        Ok(&self.block[offset..offset + self.page_bytes])
    }
}

impl Row {
    /// The field at `place`; [`SqlValue::Other`] if the row has no such field.
    pub(super) fn field(&self, place: usize) -> SqlValue<'_> {
        self.find(place).unwrap_or(SqlValue::Other)
    }

    fn find(&self, place: usize) -> Option<SqlValue<'_>> {
        let (header_bytes, types) = varint(&self.bytes).ok()?;
        let header_bytes = usize::try_from(header_bytes).ok()?;
        let mut types = types.get(..header_bytes.checked_sub(self.bytes.len() - types.len())?)?;
        let mut at = header_bytes;
        for _ in 0..place {
            let (kind, rest) = varint(types).ok()?;
            at = at.checked_add(usize::try_from(field_bytes(kind)).ok()?)?;
            types = rest;
        }
        let (kind, _) = varint(types).ok()?;
        let length = usize::try_from(field_bytes(kind)).ok()?;
        let bytes = self.bytes.get(at..at.checked_add(length)?)?;
        Some(match kind {
            0 | 7 | 10 | 11 => SqlValue::Other,
            8 => SqlValue::Integer(0),
            9 => SqlValue::Integer(1),
            1..=6 => {
                let negative = bytes[0] & 0x80 != 0;
                let mut whole = [if negative { 0xff } else { 0 }; 8];
                whole[8 - length..].copy_from_slice(bytes);
                SqlValue::Integer(i64::from_be_bytes(whole))
            }
            kind if kind % 2 == 0 => SqlValue::Blob(bytes),
            _ => SqlValue::Text(bytes),
        })
    }
}

fn field_bytes(kind: u64) -> u64 {
    match kind {
        1..=4 => kind,
        5 => 6,
        6 | 7 => 8,
        kind if kind >= 12 => (kind - 12) / 2,
        _ => 0,
    }
}

/// A number of seven bits per byte, the highest first, and the bytes after it.
fn varint(bytes: &[u8]) -> io::Result<(u64, &[u8])> {
    let mut number = 0_u64;
    for (place, &byte) in bytes.iter().take(9).enumerate() {
        if place == 8 {
            return Ok((number << 8 | u64::from(byte), &bytes[9..]));
        }
        number = number << 7 | u64::from(byte & 0x7f);
        if byte & 0x80 == 0 {
            return Ok((number, &bytes[place + 1..]));
        }
    }
    Err(damaged("a number ends outside of its page"))
}

fn cell_offset(page: &[u8], cells_at: usize, cell: usize) -> io::Result<usize> {
    let at = cells_at + 2 * cell;
    let bytes = page.get(at..at + 2).ok_or_else(|| damaged("a page has more cells than fit it"))?;
    Ok(usize::from(u16::from_be_bytes([bytes[0], bytes[1]])))
}

fn number_4(bytes: &[u8], at: usize) -> io::Result<u32> {
    let bytes = bytes.get(at..).and_then(|bytes| bytes.first_chunk());
    bytes.map(|bytes| u32::from_be_bytes(*bytes)).ok_or_else(|| damaged("a page number lies outside of its page"))
}

/// The names of the columns in `CREATE TABLE name(id INTEGER PRIMARY KEY, ...)`.
fn column_names(sql: &str) -> Vec<String> {
    let Some((_, definitions)) = sql.split_once('(') else { return Vec::new() };
    let mut depth = 0;
    let parts = definitions.split(|c: char| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        (c == ',' && depth == 0) || depth < 0
    });
    let first_word =
        |part: &str| part.split_whitespace().next().map(|word| word.trim_matches(['"', '`', '[', ']']).to_lowercase());
    parts.filter_map(first_word).collect()
}

fn damaged(problem: &str) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, format!("the database is damaged: {problem}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of pages of 512 bytes; each page after the first belongs to a table and has its kind
    /// and the pages below it.
    fn database(tables: &[(u8, &[u32])]) -> Database<io::Cursor<Vec<u8>>> {
        let mut file = vec![0; 512 * (1 + tables.len())];
        file[..16].copy_from_slice(MAGIC);
        file[16..18].copy_from_slice(&512_u16.to_be_bytes());
        for (page, (kind, below)) in file[512..].chunks_mut(512).zip(tables) {
            page[0] = *kind;
            let Some((last, branches)) = below.split_last() else { continue };
            page[3..5].copy_from_slice(&(branches.len() as u16).to_be_bytes());
            page[8..12].copy_from_slice(&last.to_be_bytes());
            for (place, branch) in branches.iter().enumerate() {
                let at = 400 + 4 * place;
                page[12 + 2 * place..][..2].copy_from_slice(&(at as u16).to_be_bytes());
                page[at..at + 4].copy_from_slice(&branch.to_be_bytes());
            }
        }
        Database::open(io::Cursor::new(file)).unwrap()
    }

    fn rows(tables: &[(u8, &[u32])]) -> io::Result<usize> {
        let mut database = database(tables);
        let (mut scan, mut row, mut rows) = (database.scan(2), Row::default(), 0);
        while database.next_row(&mut scan, &mut row)? {
            rows += 1;
        }
        Ok(rows)
    }

    /// A row of 1200 bytes: 184 are in its leaf and 508 on each of two pages. The first page leads
    /// to the page `second`.
    fn long_row(second: u32) -> (Vec<u8>, io::Result<Row>) {
        let bytes: Vec<u8> = (0..1200_u32).map(|place| (place % 251) as u8).collect();
        let mut file = vec![0; 512 * 4];
        file[..16].copy_from_slice(MAGIC);
        file[16..18].copy_from_slice(&512_u16.to_be_bytes());
        let leaf = &mut file[512..1024];
        (leaf[0], leaf[4], leaf[9]) = (13, 1, 100);
        let cell = [&[0x89, 0x30, 7], &bytes[..184], &[0, 0, 0, 3]].concat();
        leaf[100..][..cell.len()].copy_from_slice(&cell);
        file[1024..1028].copy_from_slice(&second.to_be_bytes());
        file[1028..1536].copy_from_slice(&bytes[184..692]);
        file[1540..].copy_from_slice(&bytes[692..]);
        let mut database = Database::open(io::Cursor::new(file)).unwrap();
        let (mut scan, mut row) = (database.scan(2), Row::default());
        assert!(database.next_row(&mut scan, &mut row).unwrap());
        (bytes, database.complete(&mut row).map(|()| row))
    }

    #[test]
    fn a_number_has_seven_bits_a_byte_and_eight_in_the_ninth() {
        assert_eq!(varint(&[0x7f, 1]).unwrap(), (127, [1].as_slice()));
        assert_eq!(varint(&[0x81, 0x00]).unwrap().0, 128);
        assert_eq!(varint(&[0xff; 10]).unwrap(), (u64::MAX, [0xff].as_slice()));
        assert_eq!(varint(&[0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x81, 0x02]).unwrap().0, 0x102);
        varint(&[0xff; 8]).unwrap_err();
    }

    #[test]
    fn a_long_row_continues_on_other_pages() {
        let (bytes, row) = long_row(4);
        let row = row.unwrap();
        assert!(row.id == 7 && row.bytes == bytes);
        assert!(long_row(0).1.err().unwrap().to_string().contains("ends before its length"));
    }

    #[test]
    fn each_page_of_a_table_is_read_once() {
        assert_eq!(rows(&[(5, &[3, 4]), (13, &[]), (13, &[])]).unwrap(), 0);
        for tables in [&[(5, &[2][..])][..], &[(5, &[3; 20]), (13, &[])]] {
            let error = rows(tables).unwrap_err().to_string();
            assert!(error.contains("its own branch"), "{error}");
        }
    }

    #[test]
    fn a_cut_file_with_fewer_pages_than_branches_is_read_to_its_end() {
        let error = rows(&[(5, &[3, 4, 5, 6, 7, 8]), (13, &[])]).unwrap_err().to_string();
        assert!(error.contains("it refers to page 4, and 3 are there"), "{error}");
    }

    #[test]
    fn rows_before_a_cut_are_read_though_their_branches_lie_behind_it() {
        let mut database = database(&[(5, &[9]), (13, &[]), (13, &[])]);
        // a row of two bytes in each leaf; the later one is first in the file
        for (page, id) in [(2, 5), (3, 2)] {
            let leaf = &mut database.file.get_mut()[512 * page..][..512];
            (leaf[4], leaf[9]) = (1, 100);
            leaf[100..104].copy_from_slice(&[2, id, 1, 0]);
        }
        let (mut scan, mut row, mut ids) = (database.scan(2), Row::default(), Vec::new());
        let error = loop {
            match database.next_row(&mut scan, &mut row) {
                Ok(true) => ids.push(row.id),
                ended => break ended.unwrap_err().to_string(),
            }
        };
        assert_eq!(ids, [2, 5]);
        assert!(error.contains("it refers to page 9, and 4 are there"), "{error}");
        assert!(!database.next_row(&mut scan, &mut row).unwrap());
    }
}
