#include "common/case/document.hpp"

#include "common/case/toml.hpp"
#include "common/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>

namespace poretwin {
namespace {

Node converted(const toml::node& from, const std::string& path) {
  Node node;
  node.where = fmt::format("{}:{}", path, from.source().begin.line);
  if (const auto* table = from.as_table()) {
    node.kind = Node::Kind::table;
    for (const auto& [key, value] : *table) {
      node.entries.push_back({std::string(key.str()), converted(value, path)});
      // A key's own line is a better pointer than the first line of a long value.
      if (key.source().begin.line > 0)
        node.entries.back().second.where = fmt::format("{}:{}", path, key.source().begin.line);
    }
  } else if (const auto* array = from.as_array()) {
    node.kind = Node::Kind::array;
    for (const auto& value : *array) node.items.push_back(converted(value, path));
  } else if (const auto* boolean = from.as_boolean()) {
    node.kind = Node::Kind::boolean;
    node.boolean = boolean->get();
  } else if (const auto* integer = from.as_integer()) {
    node.kind = Node::Kind::integer;
    node.integer = integer->get();
    node.number = static_cast<double>(integer->get());
  } else if (const auto* number = from.as_floating_point()) {
    node.kind = Node::Kind::number;
    node.number = number->get();
  } else if (const auto* text = from.as_string()) {
    node.kind = Node::Kind::text;
    node.text = text->get();
  } else {
    node.kind = Node::Kind::other;
  }
  return node;
}

/// The TOML library, and the tree that is made of what it reads, go down one level for every part of a key: some
/// thousands are more than the stack holds, and no key of a case has more than five.
constexpr std::size_t most_parts = 64;

/// Throws CaseError naming the line where a key has more parts than that.
void expect_shallow_keys(const std::string& text, const std::string& path) {
  std::size_t parts = 1, line = 1;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const char c = text[k];
    if (c == '#') {
      k = std::min(text.find('\n', k), text.size());
    } else if (c == '"' || c == '\'') {
      const std::string quotes(text.compare(k, 3, std::string(3, c)) == 0 ? 3 : 1, c);
      for (k += quotes.size(); k < text.size() && text.compare(k, quotes.size(), quotes) != 0; ++k) {
        if (c == '"' && text[k] == '\\') ++k;
        if (k < text.size() && text[k] == '\n') {
          ++line;
          if (quotes.size() == 1) break;  // not closed on its line: for the parser to say
        }
      }
      k += quotes.size() - 1;
      continue;
    }
    if (k < text.size() && text[k] == '.' && ++parts > most_parts)
      throw CaseError(fmt::format("{}:{}: expected a key of at most {} parts, found more", path, line, most_parts));
    if (c == '=' || c == ',' || c == '{' || c == '}' || c == '[' || c == ']') parts = 1;
    if (k < text.size() && text[k] == '\n') {
      ++line;
      parts = 1;
    }
  }
}

bool is_bare_word(std::string_view word) {
  return !word.empty() && (std::isalpha(static_cast<unsigned char>(word.front())) != 0) &&
         std::all_of(word.begin(), word.end(),
                     [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-'; });
}

Node override_value(const std::string& assignment, const std::string& value) {
  const std::string where = "--set " + assignment;
  Node node;
  if (is_bare_word(value) && value != "true" && value != "false" && value != "inf" && value != "nan") {
    node.kind = Node::Kind::text;
    node.text = value;
  } else {
    expect_shallow_keys(value, where);
    try {
      const toml::table table = toml::parse("value = " + value);
      if (table.size() != 1) throw CaseError(fmt::format("{}: expected one value after '='", where));
      node = converted(*table.get("value"), where);
    } catch (const toml::parse_error& error) {
      throw CaseError(
          fmt::format("{}: expected a value as in a case file (number, true, \"text\", [..]), found '{}': {}", where,
                      value, error.description()));
    }
  }
  return node;
}

void mark(Node& node, const std::string& where) {
  node.where = where;
  for (auto& item : node.items) mark(item, where);
  for (auto& entry : node.entries) mark(entry.second, where);
}

std::vector<std::string> path_parts(const std::string& path) {
  std::vector<std::string> parts(1);
  for (const char c : path) {
    if (c == '.' || c == '[')
      parts.emplace_back();
    else if (c != ']')
      parts.back() += c;
  }
  return parts;
}

}  // namespace

const Node* Node::find(std::string_view key) const {
  for (const auto& entry : entries)
    if (entry.first == key) return &entry.second;
  return nullptr;
}

std::string Node::shown() const {
  switch (kind) {
    case Kind::boolean:
      return boolean ? "true" : "false";
    case Kind::integer:
      return fmt::format("{}", integer);
    case Kind::number:
      return fmt::format("{}", number);
    case Kind::text:
      return fmt::format("the text \"{}\"", text);
    case Kind::array: {
      if (items.size() > 4) return fmt::format("an array of {} items", items.size());
      std::string shown = "[";
      for (const auto& item : items) shown += (shown.size() > 1 ? ", " : "") + item.shown();
      return shown + "]";
    }
    case Kind::table:
      return "a table";
    case Kind::other:
      return "a date or time";
  }
  return "nothing";
}

std::string read_text(const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    throw FileError(fmt::format("{}: expected a file, found a folder", path.string()));
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw FileError(fmt::format("{}: cannot be opened: {}", path.string(), std::strerror(errno)));
  std::ostringstream text;
  text << stream.rdbuf();
  if (stream.bad()) throw FileError(fmt::format("{}: cannot be read: {}", path.string(), std::strerror(errno)));
  return text.str();
}

Node parse_document(const std::string& text, const std::string& path) {
  expect_shallow_keys(text, path);
  try {
    Node root = converted(toml::parse(text), path);
    root.where = path;
    return root;
  } catch (const toml::parse_error& error) {
    throw CaseError(fmt::format("{}:{}: not valid TOML: {}", path, error.source().begin.line, error.description()));
  }
}

void apply_override(Node& root, const std::string& assignment) {
  const std::string where = "--set " + assignment;
  const auto equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0)
    throw CaseError(
        fmt::format("{}: expected section.key=value, for example --set fluid.particle_spacing=0.01", where));
  const auto parts = path_parts(assignment.substr(0, equals));
  if (parts.size() > most_parts)
    throw CaseError(fmt::format("--set: expected a key of at most {} parts, found {}", most_parts, parts.size()));
  Node* node = &root;
  for (const auto& part : parts) {
    if (part.empty())
      throw CaseError(fmt::format("{}: expected section.key=value, found an empty part in the key", where));
    if (node->kind == Node::Kind::array) {
      const bool digits = std::all_of(part.begin(), part.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
      const std::size_t index = digits && part.size() < 9 ? std::stoul(part) : node->items.size();
      if (index >= node->items.size())
        throw CaseError(fmt::format("{}: expected an index from 0 to {} in place of '{}'", where,
                                    static_cast<long>(node->items.size()) - 1, part));
      node = &node->items[index];
    } else if (node->kind == Node::Kind::table) {
      auto entry =
          std::find_if(node->entries.begin(), node->entries.end(), [&](const auto& e) { return e.first == part; });
      if (entry == node->entries.end()) {
        Node fresh;
        fresh.where = where;
        entry = node->entries.insert(node->entries.end(), Node::Entry{part, fresh});
      }
      node = &entry->second;
    } else {
      throw CaseError(fmt::format("{}: '{}' lies below a plain value", where, part));
    }
  }
  *node = override_value(assignment, assignment.substr(equals + 1));
  mark(*node, where);
}

}  // namespace poretwin
