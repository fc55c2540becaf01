#include "common/case/keys.hpp"

#include "common/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace poretwin {
namespace {

constexpr std::string_view axis_names = "xyz";

std::string exact(double value) { return fmt::format("{:.17g}", value); }
std::string short_number(double value) { return fmt::format("{}", value); }

std::string shown_point(const Point3& point, int dimension, std::string (*format)(double)) {
  std::string shown = "[";
  for (int d = 0; d < dimension; ++d) shown += (d > 0 ? ", " : "") + format(point[d]);
  return shown + "]";
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const auto& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string in_unit(const About& about) { return about.unit.empty() ? std::string() : " in " + about.unit; }

std::string point_form(int dimension) { return dimension == 3 ? "[x, y, z]" : "[x, y]"; }

class Reader final : public Keys {
 public:
  Reader(const Node& table, std::string path, Places* places) : table_(table), path_(std::move(path)), places_(places) {
    note(path_, table.where);
  }

  void number(std::string_view key, double& value, const About& about, const Range& range) override {
    if (const Node* node = get(key, about, expected_number(about, range))) value = checked(key, *node, about, range);
  }
  void number(std::string_view key, std::optional<double>& value, const About& about, const Range& range) override {
    if (const Node* node = get(key, about, expected_number(about, range))) value = checked(key, *node, about, range);
  }
  void integer(std::string_view key, std::int64_t& value, const About& about, const Range& range) override {
    const std::string expected = "a whole number" + (range.text().empty() ? "" : " " + range.text());
    const Node* node = get(key, about, expected);
    if (node == nullptr) return;
    if (node->kind != Node::Kind::integer || !range.holds(node->number)) wrong(key, *node, expected);
    value = node->integer;
  }
  void flag(std::string_view key, bool& value, const About& about) override {
    const Node* node = get(key, about, "true or false");
    if (node == nullptr) return;
    if (node->kind != Node::Kind::boolean) wrong(key, *node, "true or false");
    value = node->boolean;
  }
  void text(std::string_view key, std::string& value, const About& about) override {
    const Node* node = get(key, about, "a text");
    if (node == nullptr) return;
    if (node->kind != Node::Kind::text) wrong(key, *node, "a text in quotes");
    value = node->text;
  }
  void texts(std::string_view key, std::vector<std::string>& value, const About& about) override {
    const Node* node = get(key, about, "an array of texts");
    if (node == nullptr) return;
    if (node->kind != Node::Kind::array) wrong(key, *node, "an array of texts");
    value.clear();
    for (const auto& item : node->items) {
      if (item.kind != Node::Kind::text) wrong(key, item, "a text in quotes");
      value.push_back(item.text);
    }
  }
  void numbers(std::string_view key, std::vector<double>& value, const About& about) override {
    const Node* node = get(key, about, "an array of numbers");
    if (node == nullptr) return;
    if (node->kind != Node::Kind::array) wrong(key, *node, "an array of numbers");
    value.clear();
    for (const auto& item : node->items) value.push_back(checked(key, item, about, any_number()));
  }
  void point(std::string_view key, Point3& value, const About& about) override {
    if (const Node* node = get(key, about, point_form(dimension) + in_unit(about))) value = point_of(key, *node, about);
  }
  void points(std::string_view key, std::vector<Point3>& value, const About& about) override {
    const std::string expected = fmt::format("an array of points {}{}", point_form(dimension), in_unit(about));
    const Node* node = get(key, about, expected);
    if (node == nullptr) return;
    if (node->kind != Node::Kind::array || node->items.empty()) wrong(key, *node, expected);
    value.clear();
    for (const auto& item : node->items) value.push_back(point_of(key, item, about));
  }
  void axes(std::string_view key, std::vector<int>& value, const About& about) override {
    const std::string expected = dimension == 3 ? R"(an array of "x", "y", "z")" : R"(an array of "x", "y")";
    const Node* node = get(key, about, expected);
    if (node == nullptr) return;
    if (node->kind != Node::Kind::array) wrong(key, *node, expected);
    value.clear();
    for (const auto& item : node->items) {
      const auto axis =
          item.kind == Node::Kind::text && item.text.size() == 1 ? axis_names.find(item.text[0]) : axis_names.npos;
      if (axis == axis_names.npos || static_cast<int>(axis) >= dimension) wrong(key, item, expected);
      if (std::find(value.begin(), value.end(), static_cast<int>(axis)) != value.end())
        wrong(key, *node, "each axis at most once");
      value.push_back(static_cast<int>(axis));
    }
    std::sort(value.begin(), value.end());
  }
  void series(std::string_view key, std::optional<Series>& value, const About& about) override {
    const std::string expected = fmt::format("a number{} or a table [[t, value], ...]", in_unit(about));
    const Node* node = get(key, about, expected);
    if (node == nullptr) return;
    Series series;
    if (node->is_number()) {
      series.knots = {{0.0, checked(key, *node, about, any_number())}};
    } else {
      if (node->kind != Node::Kind::array || node->items.empty()) wrong(key, *node, expected);
      for (const auto& item : node->items) {
        if (item.kind != Node::Kind::array || item.items.size() != 2) wrong(key, item, expected);
        series.knots.emplace_back(checked(key, item.items[0], About{"s", ""}, any_number()),
                                  checked(key, item.items[1], about, any_number()));
        const auto n = series.knots.size();
        if (n > 1 && series.knots[n - 1].first <= series.knots[n - 2].first)
          wrong(key, item, "times that increase from row to row");
      }
    }
    value = series;
  }

  /// Called after the last key: reports undeclared keys of the file, then required keys that are missing.
  void finish() const {
    for (const auto& [key, node] : table_.entries) {
      if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
      throw CaseError(fmt::format("{}: key '{}' is not known; did you mean '{}'? Keys here: {}", node.where, full(key),
                                  nearest(key, known_), joined(known_)));
    }
    if (!missing_.empty()) throw CaseError(missing_);
  }

 protected:
  void word(std::string_view key, std::optional<std::size_t>& index, const std::vector<std::string_view>& names,
            const About& about) override {
    std::vector<std::string> quoted, plain;
    for (const auto name : names) {
      quoted.push_back(fmt::format("\"{}\"", name));
      plain.emplace_back(name);
    }
    const std::string expected = "one of " + joined(quoted);
    const Node* node = get(key, about, expected);
    if (node == nullptr) return;
    const auto found = node->kind == Node::Kind::text ? std::find(names.begin(), names.end(), node->text) : names.end();
    if (found == names.end())
      wrong(key, *node, expected,
            node->kind == Node::Kind::text ? fmt::format("; did you mean \"{}\"?", nearest(node->text, plain)) : "");
    index = static_cast<std::size_t>(found - names.begin());
  }
  void group(std::string_view key, std::string_view, bool optional, bool,
             const std::function<void(Keys&)>& body) override {
    known_.emplace_back(key);
    const Node* node = table_.find(key);
    if (node == nullptr && optional) return;
    if (node != nullptr && node->kind != Node::Kind::table) wrong(key, *node, fmt::format("a table [{}]", key));
    Node absent;
    absent.where = table_.where;
    run(node != nullptr ? *node : absent, full(key), body);
  }
  void each(std::string_view key, std::string_view, std::size_t,
            const std::function<void(Keys&, std::size_t)>& body) override {
    known_.emplace_back(key);
    const Node* node = table_.find(key);
    if (node == nullptr) return;
    const std::string expected = fmt::format("tables [[{}]]", full(key));
    if (node->kind == Node::Kind::table)
      wrong(key, *node, expected, fmt::format("; there may be several: write [[{}]], in double brackets", full(key)));
    if (node->kind != Node::Kind::array) wrong(key, *node, expected);
    for (std::size_t i = 0; i < node->items.size(); ++i) {
      if (node->items[i].kind != Node::Kind::table) wrong(key, node->items[i], expected);
      run(node->items[i], fmt::format("{}[{}]", full(key), i), [&](Keys& keys) { body(keys, i); });
    }
  }

 private:
  void run(const Node& node, const std::string& path, const std::function<void(Keys&)>& body) const {
    Reader reader(node, path, places_);
    reader.dimension = dimension;
    body(reader);
    reader.finish();
  }
  void note(const std::string& path, const std::string& where) const {
    if (places_ != nullptr) (*places_)[path] = where;
  }
  [[nodiscard]] std::string full(std::string_view key) const {
    return path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key);
  }
  const Node* get(std::string_view key, const About& about, const std::string& expected) {
    known_.emplace_back(key);
    const Node* node = table_.find(key);
    if (node != nullptr)
      note(full(key), node->where);
    else if (about.required && missing_.empty())
      missing_ =
          fmt::format("{}: key '{}' is missing; expected {}: {}", table_.where, full(key), expected, about.meaning);
    return node;
  }
  [[noreturn]] void wrong(std::string_view key, const Node& node, const std::string& expected,
                          const std::string& hint = "") const {
    throw CaseError(
        fmt::format("{}: key '{}': expected {}, found {}{}", node.where, full(key), expected, node.shown(), hint));
  }
  static std::string expected_number(const About& about, const Range& range) {
    return "a number" + (range.text().empty() ? "" : " " + range.text()) + in_unit(about);
  }
  double checked(std::string_view key, const Node& node, const About& about, const Range& range) const {
    if (!node.is_number() || !std::isfinite(node.number) || !range.holds(node.number))
      wrong(key, node, expected_number(about, range));
    return node.number;
  }
  Point3 point_of(std::string_view key, const Node& node, const About& about) const {
    const std::string expected = point_form(dimension) + in_unit(about);
    if (node.kind != Node::Kind::array || node.items.size() != static_cast<std::size_t>(dimension))
      wrong(key, node, expected);
    Point3 point = Point3::Zero();
    for (std::size_t d = 0; d < node.items.size(); ++d)
      point[static_cast<Eigen::Index>(d)] = checked(key, node.items[d], about, any_number());
    return point;
  }

  const Node& table_;
  std::string path_;
  Places* places_;
  std::vector<std::string> known_;
  std::string missing_;
};

class Describer final : public Keys {
 public:
  explicit Describer(std::string heading) : heading_(std::move(heading)) {}

  void number(std::string_view key, double& value, const About& about, const Range& range) override {
    row(key, "number", about, short_number(value), range.text());
  }
  void number(std::string_view key, std::optional<double>& value, const About& about, const Range& range) override {
    row(key, "number", about, value ? short_number(*value) : "", range.text());
  }
  void integer(std::string_view key, std::int64_t& value, const About& about, const Range& range) override {
    row(key, "whole number", about, fmt::format("{}", value), range.text());
  }
  void flag(std::string_view key, bool& value, const About& about) override {
    row(key, "true or false", about, value ? "true" : "false", "");
  }
  void text(std::string_view key, std::string& value, const About& about) override {
    row(key, "text", about, value.empty() ? "" : '"' + value + '"', "");
  }
  void texts(std::string_view key, std::vector<std::string>&, const About& about) override {
    row(key, "texts", about, "", "");
  }
  void numbers(std::string_view key, std::vector<double>&, const About& about) override {
    row(key, "numbers", about, "", "");
  }
  void point(std::string_view key, Point3& value, const About& about) override {
    row(key, "point", about, shown_point(value, dimension, short_number), "");
  }
  void points(std::string_view key, std::vector<Point3>&, const About& about) override {
    row(key, "points", about, "", "");
  }
  void axes(std::string_view key, std::vector<int>&, const About& about) override {
    row(key, "axes", about, "[]", R"("x", "y", "z")");
  }
  void series(std::string_view key, std::optional<Series>&, const About& about) override {
    row(key, "number or [[t, value], ...]", about, "", "t increasing");
  }

  [[nodiscard]] std::string result() const {
    std::string text;
    if (!heading_.empty()) text += fmt::format("## `{}`\n\n{}\n\n", heading_, meaning_);
    if (!rows_.empty())
      text +=
          "| Key | Type | Unit | Default | Allowed | Meaning |\n| --- | --- | --- | --- | --- | --- |\n" + rows_ + "\n";
    return text + below_;
  }

 protected:
  void word(std::string_view key, std::optional<std::size_t>& index, const std::vector<std::string_view>& names,
            const About& about) override {
    std::string allowed;
    for (const auto name : names) allowed += fmt::format("{}\"{}\"", allowed.empty() ? "" : ", ", name);
    row(key, "word", about, index ? fmt::format("\"{}\"", names[*index]) : "", allowed);
  }
  void group(std::string_view key, std::string_view meaning, bool, bool,
             const std::function<void(Keys&)>& body) override {
    below(fmt::format("[{}]", full(key)), full(key), meaning, body);
  }
  void each(std::string_view key, std::string_view meaning, std::size_t,
            const std::function<void(Keys&, std::size_t)>& body) override {
    below(fmt::format("[[{}]]", full(key)), full(key), meaning, [&](Keys& keys) { body(keys, 0); });
  }
  void each_as_elsewhere(std::string_view key, const About& about, std::size_t,
                         const std::function<void(Keys&, std::size_t)>&) override {
    row(key, "tables", about, "", "");
  }

 private:
  [[nodiscard]] std::string full(std::string_view key) const {
    return path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key);
  }
  void below(const std::string& heading, std::string path, std::string_view meaning,
             const std::function<void(Keys&)>& body) {
    Describer inner(heading);
    inner.path_ = std::move(path);
    inner.meaning_ = meaning;
    inner.dimension = dimension;
    body(inner);
    below_ += inner.result();
  }
  void row(std::string_view key, std::string_view type, const About& about, const std::string& initial,
           const std::string& allowed) {
    rows_ += fmt::format("| `{}` | {} | {} | {} | {} | {} |\n", key, type, about.unit,
                         about.required ? "required" : initial, allowed, about.meaning);
  }

  std::string heading_, path_, meaning_, rows_, below_;
};

class Lister final : public Keys {
 public:
  void number(std::string_view key, double& value, const About&, const Range&) override { line(key, exact(value)); }
  void number(std::string_view key, std::optional<double>& value, const About&, const Range&) override {
    line(key, value ? exact(*value) : "none");
  }
  void integer(std::string_view key, std::int64_t& value, const About&, const Range&) override {
    line(key, fmt::format("{}", value));
  }
  void flag(std::string_view key, bool& value, const About&) override { line(key, value ? "true" : "false"); }
  void text(std::string_view key, std::string& value, const About&) override { line(key, value); }
  void texts(std::string_view key, std::vector<std::string>& value, const About&) override { line(key, joined(value)); }
  void numbers(std::string_view key, std::vector<double>& value, const About&) override {
    std::string text;
    for (const double v : value) text += exact(v) + " ";
    line(key, text);
  }
  void point(std::string_view key, Point3& value, const About&) override { line(key, shown_point(value, 3, exact)); }
  void points(std::string_view key, std::vector<Point3>& value, const About&) override {
    std::string text;
    for (const auto& p : value) text += shown_point(p, 3, exact) + " ";
    line(key, text);
  }
  void axes(std::string_view key, std::vector<int>& value, const About&) override {
    std::string text;
    for (const int axis : value) text += axis_names[static_cast<std::size_t>(axis)];
    line(key, text);
  }
  void series(std::string_view key, std::optional<Series>& value, const About&) override {
    std::string text;
    if (value)
      for (const auto& [t, v] : value->knots) text += exact(t) + ":" + exact(v) + " ";
    line(key, value ? text : "none");
  }
  [[nodiscard]] const std::string& result() const { return text_; }

 protected:
  void word(std::string_view key, std::optional<std::size_t>& index, const std::vector<std::string_view>& names,
            const About&) override {
    line(key, index ? std::string(names[*index]) : "none");
  }
  void group(std::string_view key, std::string_view, bool, bool present,
             const std::function<void(Keys&)>& body) override {
    if (present) inside(std::string(key), body);
  }
  void each(std::string_view key, std::string_view, std::size_t present,
            const std::function<void(Keys&, std::size_t)>& body) override {
    for (std::size_t i = 0; i < present; ++i) inside(fmt::format("{}[{}]", key, i), [&](Keys& keys) { body(keys, i); });
  }

 private:
  void inside(const std::string& key, const std::function<void(Keys&)>& body) {
    const std::string before = path_;
    path_ += key + ".";
    body(*this);
    path_ = before;
  }
  void line(std::string_view key, const std::string& value) { text_ += fmt::format("{}{} = {}\n", path_, key, value); }

  std::string path_, text_;
};

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0u : 1u);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

bool Range::holds(double value) const {
  return (min_excluded ? value > min : value >= min) && (max_excluded ? value < max : value <= max);
}

std::string Range::text() const {
  const bool below = std::isfinite(min), above = std::isfinite(max);
  if (below && above) return fmt::format("in {}{}, {}{}", min_excluded ? '(' : '[', min, max, max_excluded ? ')' : ']');
  if (below) return fmt::format("{} {}", min_excluded ? ">" : ">=", min);
  if (above) return fmt::format("{} {}", max_excluded ? "<" : "<=", max);
  return {};
}

Range any_number() { return {}; }
Range positive() { return {0.0, std::numeric_limits<double>::infinity(), true, false}; }
Range not_negative() { return {0.0, std::numeric_limits<double>::infinity(), false, false}; }
Range between(double min, bool min_excluded, double max, bool max_excluded) {
  return {min, max, min_excluded, max_excluded};
}

void read_keys(const Node& root, const std::function<void(Keys&)>& declare, Places* places) {
  Reader reader(root, "", places);
  declare(reader);
  reader.finish();
}

std::string describe_keys(const std::function<void(Keys&)>& declare) {
  Describer describer("");
  declare(describer);
  return describer.result();
}

std::string list_keys(const std::function<void(Keys&)>& declare) {
  Lister lister;
  declare(lister);
  return lister.result();
}

std::string nearest(std::string_view word, const std::vector<std::string>& candidates) {
  std::string best;
  std::size_t best_distance = std::numeric_limits<std::size_t>::max();
  for (const auto& candidate : candidates) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

}  // namespace poretwin
