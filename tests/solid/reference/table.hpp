// Reference tables: comma separated, with the column names in the first line.
#pragma once

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace poretwin::test {

class Table {
 public:
  /// Reads a file of this folder; lines that begin with # are comments.
  static Table read(const std::string& name) {
    std::ifstream file(std::string(PORETWIN_SOURCE_DIR) + "/tests/solid/reference/" + name);
    if (!file) throw std::runtime_error(name + ": no such table");
    Table table;
    for (std::string line; std::getline(file, line);) {
      if (line.empty() || line[0] == '#') continue;
      std::vector<std::string> words;
      std::istringstream stream(line);
      for (std::string word; std::getline(stream, word, ',');) words.push_back(word);
      (table.names_.empty() ? table.names_ : table.rows_.emplace_back()) = words;
    }
    return table;
  }
  [[nodiscard]] std::size_t size() const { return rows_.size(); }
  [[nodiscard]] const std::string& word(std::size_t row, const std::string& name) const {
    const auto found = std::find(names_.begin(), names_.end(), name);
    if (found == names_.end()) throw std::runtime_error("no column " + name);
    return rows_.at(row).at(static_cast<std::size_t>(found - names_.begin()));
  }
  [[nodiscard]] double number(std::size_t row, const std::string& name) const { return std::stod(word(row, name)); }

 private:
  std::vector<std::string> names_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace poretwin::test
