#include "instruments/files/table.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

namespace files {
namespace {

Table::Row split(const std::string& line, char separator) {
  Table::Row cells{""};
  for (const char c : line)
    if (c == separator)
      cells.emplace_back();
    else
      cells.back() += c;
  return cells;
}

}  // namespace

std::string Table::text(const std::vector<int>& widths) const {
  std::string text;
  for (const Row& row : rows_) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      const int width = i < widths.size() ? widths[i] : 0;
      text +=
          width < 0 ? fmt::format("{:<{}}", row[i], -width) : fmt::format("{:>{}}", row[i], width);
    }
    text += '\n';
  }
  return text;
}

std::string Table::csv(char separator) const {
  std::string text;
  for (const std::string& note : notes_) text += "# " + note + "\n";
  for (const Row& row : rows_) text += csv_line(row, separator);
  return text;
}

std::string digits(double value, int count) {
  return std::isnan(value) ? "" : fmt::format("{:.{}g}", value, count);
}

std::string csv_line(const Table::Row& cells, char separator) {
  std::string line;
  for (const std::string& cell : cells) {
    const auto begin = static_cast<std::ptrdiff_t>(line.size());
    line += cell;
    std::replace(line.begin() + begin, line.end(), separator, separator == ',' ? ';' : ',');
    line += separator;
  }
  line.back() = '\n';
  return line;
}

std::string SavedRow::operator[](const std::string& column) const {
  const auto found = std::find(header_.begin(), header_.end(), column);
  return found == header_.end() ? "" : cells_.at(static_cast<std::size_t>(found - header_.begin()));
}

void read_csv(const std::filesystem::path& path, const TakeRow& row, const TakeNote& note,
              char separator) {
  std::ifstream stream(path);
  read_csv(stream, path.string(), row, note, separator);
}

void read_csv(std::istream& stream, const std::string& name, const TakeRow& row,
              const TakeNote& note, char separator) {
  if (!stream) throw std::runtime_error(fmt::format("cannot read {}", name));
  Table::Row header;
  for (std::string line; std::getline(stream, line);) try {
      if (line.starts_with("# ")) {
        const std::size_t colon = line.find(": ");
        if (note) note(line.substr(2, colon - 2), line.substr(colon + 2));
      } else if (header.empty()) {
        header = split(line, separator);
      } else {
        row({header, split(line, separator)});
      }
    } catch (const std::logic_error&) {  // std::out_of_range, std::invalid_argument
      throw std::runtime_error(fmt::format("{}: this line does not fit: {}", name, line));
    }
}

}  // namespace files
