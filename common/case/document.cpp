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
      // The line of the key is given, since the value may begin on a later line or extend over several.
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

/// Largest number of parts of a dotted key. The TOML library, and the tree made from its result, recurse once per part:
/// thousands of parts overflow the stack, and no key of a case has more than five.
constexpr std::size_t most_parts = 64;

/// Throws CaseError naming the line of a key with more than `most_parts` parts.
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
          if (quotes.size() == 1) break;  // the string is not closed on its line; the parser reports that
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

bool all_digits(const std::string& word) {
  return !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

/// The likeliest mistake in the text up to a line: the parser's own message gives only the line at which it stopped.
std::string likely_mistake(const std::string& text, std::size_t line) {
  std::istringstream stream(text);
  std::string here;
  std::vector<std::pair<std::size_t, std::string>> open;  // arrays that are not closed yet
  std::size_t number = 0;
  long depth = 0;
  for (std::string read; number < line && std::getline(stream, read);) {
    ++number;
    here = read;
    char quote = 0;
    const long before = depth;
    for (const char c : read) {
      if (quote != 0) {
        if (c == quote) quote = 0;
      } else if (c == '"' || c == '\'') {
        quote = c;
      } else if (c == '#') {
        break;
      } else if (c == '[' || c == ']') {
        depth += c == '[' ? 1 : -1;
      }
    }
    if (quote != 0 && number == line) return fmt::format("a quote {} is missing in: {}", quote, read);
    if (depth > before && number < line) open.emplace_back(number, read);
    if (depth <= 0) {
      depth = 0;
      open.clear();
    }
  }
  if (!open.empty())
    return fmt::format("the array that begins in line {} is not closed by a ']': {}", open.front().first,
                       open.front().second);
  const auto equals = here.find('=');
  if (equals == std::string::npos) return fmt::format("expected key = value, found: {}", here);
  std::string value = here.substr(equals + 1);
  value.erase(0, value.find_first_not_of(" \t"));
  value.erase(value.find_last_not_of(" \t\r") + 1);
  if (value.empty()) return fmt::format("a value is missing after '=' in: {}", here);
  if (is_bare_word(value)) return fmt::format("a text stands in quotes, \"{}\", in: {}", value, here);
  if (std::isdigit(static_cast<unsigned char>(value.front())) != 0 && value.find(',') != std::string::npos)
    return fmt::format("a number has a decimal point, no comma, in: {}", here);
  const bool plain = value.find_first_not_of("0123456789+-.eE_") == std::string::npos;
  if (!plain && std::isdigit(static_cast<unsigned char>(value.front())) != 0)
    return fmt::format("expected a number alone (units are SI and stay out), found: {}", here);
  return fmt::format("in: {}", here);
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
    throw CaseError(fmt::format("{}:{}: not valid TOML: {} ({})", path, error.source().begin.line,
                                likely_mistake(text, error.source().begin.line), error.description()));
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
  std::string so_far;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const std::string& part = parts[k];
    if (part.empty())
      throw CaseError(fmt::format("{}: expected section.key=value, found an empty part in the key", where));
    if (node->kind == Node::Kind::array) {
      const std::size_t many = node->items.size();
      const std::size_t index = all_digits(part) && part.size() < 9 ? std::stoul(part) : many;
      if (index >= many) {
        const std::string has = fmt::format("the case has {} [[{}]]", many, so_far);
        const std::string counted =
            many == 1 ? fmt::format("{}.0", so_far) : fmt::format("{0}.0 to {0}.{1}", so_far, many - 1);
        throw CaseError(all_digits(part) ? fmt::format("{}: {}, counted from 0: expected {}, found {}.{}", where, has,
                                                       counted, so_far, part)
                                         : fmt::format("{}: {}: expected {} with its number, found '{}' in its place",
                                                       where, has, counted, part));
      }
      node = &node->items[index];
    } else if (node->kind == Node::Kind::table) {
      auto entry =
          std::find_if(node->entries.begin(), node->entries.end(), [&](const auto& e) { return e.first == part; });
      if (entry == node->entries.end()) {
        if (k + 1 < parts.size() && all_digits(parts[k + 1]))
          throw CaseError(fmt::format("{}: the case has no [[{}{}]]; expected one in the case file", where,
                                      so_far.empty() ? "" : so_far + ".", part));
        Node fresh;
        fresh.where = where;
        entry = node->entries.insert(node->entries.end(), Node::Entry{part, fresh});
      }
      node = &entry->second;
    } else {
      throw CaseError(fmt::format("{}: '{}' lies below a plain value", where, part));
    }
    so_far += (so_far.empty() ? "" : ".") + part;
  }
  *node = override_value(assignment, assignment.substr(equals + 1));
  mark(*node, where);
}

}  // namespace poretwin
