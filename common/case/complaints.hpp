// Base of the checks of a case: reports faults with file, line and key.
#pragma once

#include "common/case/case.hpp"
#include "common/case/keys.hpp"
#include "common/core/error.hpp"

#include <fmt/format.h>

#include <span>
#include <string>
#include <string_view>

namespace poretwin {

class Complaints {
 public:
  Complaints(const Case& scene, const Places& places) : scene_(scene), places_(places) {}

 protected:
  /// "path:line" of the key, or of the closest table around it that the file contains.
  [[nodiscard]] std::string place(const std::string& key) const {
    for (std::string path = key;;) {
      if (const auto found = places_.find(path); found != places_.end()) return found->second;
      const auto dot = path.find_last_of(".[");
      if (dot == std::string::npos) return scene_.path.string();
      path.resize(dot);
    }
  }
  [[nodiscard]] std::string said(const std::string& key, const std::string& message) const {
    return fmt::format("{}: key '{}': {}", place(key), key, message);
  }
  [[noreturn]] void fail(const std::string& key, const std::string& message) const {
    throw CaseError(said(key, message));
  }
  [[nodiscard]] bool given(const std::string& key) const { return places_.find(key) != places_.end(); }

  /// A point in the coordinates of the file, as text [m].
  [[nodiscard]] std::string shown(const Point3& point) const {
    const Point3 x = point + scene_.general.origin;
    const int digits = scene_.general.origin.isZero() ? 6 : 12;
    return scene_.general.dimension == 3
               ? fmt::format("[{:.{}g}, {:.{}g}, {:.{}g}]", x.x(), digits, x.y(), digits, x.z(), digits)
               : fmt::format("[{:.{}g}, {:.{}g}]", x.x(), digits, x.y(), digits);
  }

  /// Refuses a name that an earlier item of the section has: a gauge of that name would read both, or one of them.
  template <class Items>
  void own_name(const Items& items, std::size_t i, const char* section) const {
    for (std::size_t j = 0; j < i && !items[i].name.empty(); ++j)
      if (items[j].name == items[i].name)
        fail(fmt::format("{}[{}].name", section, i),
             fmt::format("expected a name of its own, found \"{}\" twice", items[i].name));
  }

  /// Name of a table in messages: soil[0], or soil[0] "dam".
  static std::string named(std::string_view section, std::size_t i, const std::string& name) {
    return name.empty() ? fmt::format("{}[{}]", section, i) : fmt::format("{}[{}] \"{}\"", section, i, name);
  }

  const Case& scene_;
  const Places& places_;
};

}  // namespace poretwin
