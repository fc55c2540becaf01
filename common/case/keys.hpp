// Keys of a file, each declared once: the same declaration reads and checks the keys, describes them and lists them.
#pragma once

#include "common/case/case.hpp"
#include "common/case/document.hpp"

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace poretwin {

/// The description of a key.
struct About {
  std::string unit;     ///< SI; empty where it has no unit
  std::string meaning;  ///< one line
  bool required = false;
};

/// The range of allowed numbers.
struct Range {
  double min = -std::numeric_limits<double>::infinity(), max = std::numeric_limits<double>::infinity();
  bool min_excluded = false, max_excluded = false;
  [[nodiscard]] bool holds(double value) const;
  /// "> 0", ">= 0", "in (0, 1)", or empty.
  [[nodiscard]] std::string text() const;
};
Range any_number();
Range positive();
Range not_negative();
Range between(double min, bool min_excluded, double max, bool max_excluded);

/// One table of a file, visited key by key.
class Keys {
 public:
  Keys() = default;
  Keys(const Keys&) = delete;
  Keys& operator=(const Keys&) = delete;
  virtual ~Keys() = default;

  virtual void number(std::string_view key, double& value, const About& about, const Range& range = any_number()) = 0;
  virtual void number(std::string_view key, std::optional<double>& value, const About& about,
                      const Range& range = any_number()) = 0;
  virtual void integer(std::string_view key, std::int64_t& value, const About& about,
                       const Range& range = any_number()) = 0;
  virtual void flag(std::string_view key, bool& value, const About& about) = 0;
  virtual void text(std::string_view key, std::string& value, const About& about) = 0;
  virtual void texts(std::string_view key, std::vector<std::string>& value, const About& about) = 0;
  virtual void numbers(std::string_view key, std::vector<double>& value, const About& about) = 0;
  /// A point with `dimension` coordinates.
  virtual void point(std::string_view key, Point3& value, const About& about) = 0;
  virtual void points(std::string_view key, std::vector<Point3>& value, const About& about) = 0;
  virtual void axes(std::string_view key, std::vector<int>& value, const About& about) = 0;
  virtual void series(std::string_view key, std::optional<Series>& value, const About& about) = 0;

  /// One of several words. If `value` belongs to none of them, the first word is the default.
  template <class E>
  void choice(std::string_view key, E& value, std::span<const std::pair<std::string_view, E>> words,
              const About& about) {
    std::optional<E> chosen = words.front().second;
    for (const auto& [word, meant] : words)
      if (value == meant) chosen = value;
    choice(key, chosen, words, about);
    value = *chosen;
  }
  /// One of several words, or no word.
  template <class E>
  void choice(std::string_view key, std::optional<E>& value, std::span<const std::pair<std::string_view, E>> words,
              const About& about) {
    std::vector<std::string_view> names;
    std::optional<std::size_t> index;
    for (std::size_t i = 0; i < words.size(); ++i) {
      names.push_back(words[i].first);
      if (value == words[i].second) index = i;
    }
    word(key, index, names, about);
    if (index) value = words[*index].second;
  }

  template <class Body>
  void table(std::string_view key, std::string_view meaning, Body body) {
    group(key, meaning, false, true, [&](Keys& keys) { body(keys); });
  }
  template <class T, class Body>
  void optional_table(std::string_view key, std::string_view meaning, std::optional<T>& item, Body body) {
    group(key, meaning, true, item.has_value(), [&](Keys& keys) {
      if (!item) item.emplace();
      body(keys, *item);
    });
  }
  template <class T, class Body>
  void tables(std::string_view key, std::string_view meaning, std::vector<T>& items, Body body) {
    each(key, meaning, items.size(), [&](Keys& keys, std::size_t i) {
      if (items.size() <= i) items.resize(i + 1);
      body(keys, items[i]);
    });
  }

  /// Tables whose keys are described in another place.
  template <class T, class Body>
  void tables(std::string_view key, const About& about, std::vector<T>& items, Body body) {
    each_as_elsewhere(key, about, items.size(), [&](Keys& keys, std::size_t i) {
      if (items.size() <= i) items.resize(i + 1);
      body(keys, items[i]);
    });
  }

  int dimension = 2;  ///< number of coordinates of the points that are declared afterwards

 protected:
  /// index: position of the chosen word in `names`; absent if no word is chosen.
  virtual void word(std::string_view key, std::optional<std::size_t>& index, const std::vector<std::string_view>& names,
                    const About& about) = 0;
  virtual void group(std::string_view key, std::string_view meaning, bool optional, bool present,
                     const std::function<void(Keys&)>& body) = 0;
  virtual void each(std::string_view key, std::string_view meaning, std::size_t present,
                    const std::function<void(Keys&, std::size_t)>& body) = 0;
  virtual void each_as_elsewhere(std::string_view key, const About& about, std::size_t present,
                                 const std::function<void(Keys&, std::size_t)>& body) {
    each(key, about.meaning, present, body);
  }
};

/// "path:line" of each key, for checks after the file is read.
using Places = std::map<std::string, std::string, std::less<>>;

/// Fills the variables that `declare` binds with the values of the document. Throws CaseError for unknown or missing
/// keys, wrong types and values outside their range.
void read_keys(const Node& root, const std::function<void(Keys&)>& declare, Places* places = nullptr);

/// Markdown tables of all keys that `declare` binds; the values of the bound variables are the defaults.
std::string describe_keys(const std::function<void(Keys&)>& declare);

/// Lines "path = value" for the bound variables, in the order of declaration.
std::string list_keys(const std::function<void(Keys&)>& declare);

/// The candidate closest to `word` by edit distance; empty if there are no candidates.
std::string nearest(std::string_view word, const std::vector<std::string>& candidates);

}  // namespace poretwin
