// A TOML file as a plain tree that records where each value is written, so that every message can name file and line.
// Only document.cpp uses the TOML library.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace poretwin {

struct Node {
  enum class Kind { boolean, integer, number, text, array, table, other };
  Kind kind = Kind::table;
  bool boolean = false;
  std::int64_t integer = 0;
  double number = 0.0;  ///< also set for integers
  std::string text;
  std::vector<Node> items;  ///< elements of an array
  struct Entry;
  std::vector<Entry> entries;  ///< keys and values of a table
  std::string where;           ///< "path:line", or "--set key=value"

  [[nodiscard]] const Node* find(std::string_view key) const;
  [[nodiscard]] bool is_number() const { return kind == Kind::integer || kind == Kind::number; }
  /// The value as text, as messages quote it.
  [[nodiscard]] std::string shown() const;
};

struct Node::Entry {
  std::string first;  ///< key
  Node second;
};

/// The whole file as text. Throws FileError when it cannot be read.
std::string read_text(const std::filesystem::path& path);

/// The tree of a text. Throws CaseError with path and line when the text is not TOML.
Node parse_document(const std::string& text, const std::string& path);

/// Applies "section.key=value", "section.0.key=value" or "section[0].key=value". A value that is a bare word is text.
/// Throws CaseError when the path does not fit the document or the value is not TOML.
void apply_override(Node& root, const std::string& assignment);

}  // namespace poretwin
