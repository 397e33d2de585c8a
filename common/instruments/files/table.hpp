#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <utility>
#include <vector>

namespace files {

/// Rows of cells under a header, for the eye and for a file.
class Table {
 public:
  using Row = std::vector<std::string>;

  explicit Table(Row header) : rows_{std::move(header)} {}

  /// A line of its own ahead of the header in a file: "# name: value".
  void note(const std::string& name, const std::string& value) { note(name + ": " + value); }
  void note(std::string name_and_value) { notes_.push_back(std::move(name_and_value)); }

  Row& header() { return rows_.front(); }
  /// A row of cells as fmt writes them. It may be shorter than the header, and may grow.
  template <class... Cells>
  Row& add(const Cells&... cells) {
    return rows_.emplace_back(Row{fmt::format("{}", cells)...});
  }

  /// For the eye: cells as wide as said, in characters; a negative width is that of one aligned to
  /// the left. What stands beyond the widths is written as it is.
  std::string text(const std::vector<int>& widths) const;

  /// For a file, a line a row.
  std::string csv(char separator = ',') const;

 private:
  std::vector<std::string> notes_;
  std::vector<Row> rows_;
};

/// A number with so many digits as a cell; empty where it is none.
std::string digits(double value, int count = 6);

/// A row as a line of a file. A comma in a cell becomes a semicolon where it would separate, and
/// the other way round.
std::string csv_line(const Table::Row& cells, char separator = ',');

/// A row of a file, by the names of its columns.
class SavedRow {
 public:
  SavedRow(const Table::Row& header, Table::Row cells)
      : header_(header), cells_(std::move(cells)) {}
  /// Empty where there is no such column.
  std::string operator[](const std::string& column) const;
  /// Throws std::logic_error where the cell is no number.
  template <class Number = double>
  Number number(const std::string& column) const {
    return static_cast<Number>(std::stod((*this)[column]));
  }

 private:
  const Table::Row& header_;
  Table::Row cells_;
};

using TakeRow = std::function<void(const SavedRow&)>;
using TakeNote = std::function<void(const std::string& name, const std::string& value)>;

/// What csv() wrote, note by note and row by row. Throws std::runtime_error where the file, called
/// `name`, cannot be read, and at a line with too few cells or at which one of the two throws
/// std::logic_error.
void read_csv(const std::filesystem::path& path, const TakeRow& row, const TakeNote& note = {},
              char separator = ',');
void read_csv(std::istream& stream, const std::string& name, const TakeRow& row,
              const TakeNote& note = {}, char separator = ',');

}  // namespace files
