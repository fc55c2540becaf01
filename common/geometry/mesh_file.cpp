#include "common/geometry/mesh_file.hpp"

#include "common/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

namespace poretwin {
namespace {

constexpr std::size_t most_facets = 20'000'000;

[[noreturn]] void wrong(const std::string& where, const std::string& expected, std::string_view found) {
  throw CaseError(fmt::format("{}: expected {}, found '{}'", where, expected, found.substr(0, 40)));
}

/// The words of a text, read line by line.
class Words {
 public:
  explicit Words(std::string_view text) : rest_(text) {}

  /// Reads the next line that has words; returns false at the end of the text.
  bool next_line() {
    words_.clear();
    while (words_.empty() && !rest_.empty()) {
      ++line_;
      const auto end = rest_.find('\n');
      std::string_view line = rest_.substr(0, end);
      rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(end + 1);
      constexpr std::string_view blank = " \t\r\f\v";
      for (auto from = line.find_first_not_of(blank); from != std::string_view::npos;) {
        const auto to = std::min(line.find_first_of(blank, from), line.size());
        words_.push_back(line.substr(from, to - from));
        from = line.find_first_not_of(blank, to);
      }
    }
    return !words_.empty();
  }
  [[nodiscard]] const std::vector<std::string_view>& words() const { return words_; }
  [[nodiscard]] std::string_view rest() const { return rest_; }
  [[nodiscard]] std::string where() const { return fmt::format("line {}", line_); }
  [[nodiscard]] std::string line() const {
    std::string all;
    for (const auto word : words_) all += fmt::format("{}{}", all.empty() ? "" : " ", word);
    return all;
  }

  /// Word i of the line as a finite number.
  [[nodiscard]] double number(std::size_t i, const char* expected) const {
    double value = 0.0;
    if (i >= words_.size() || !read(words_[i], value) || !std::isfinite(value)) wrong(where(), expected, line());
    return value;
  }
  [[nodiscard]] Vec<3> point(std::size_t first) const {
    Vec<3> x;
    for (std::size_t d = 0; d < 3; ++d) x[static_cast<Eigen::Index>(d)] = number(first + d, "three coordinates");
    return x;
  }
  template <class T>
  static bool read(std::string_view word, T& value) {
    if (word.starts_with('+')) word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc() && end == word.data() + word.size();
  }

 private:
  std::string_view rest_;
  std::vector<std::string_view> words_;
  std::size_t line_ = 0;
};

/// Adds a polygon as a fan of triangles.
void add_polygon(const std::vector<Index>& corners, Triangles& mesh) {
  for (std::size_t c = 1; c + 1 < corners.size(); ++c) mesh.facets.push_back({corners[0], corners[c], corners[c + 1]});
  if (mesh.facets.size() > most_facets)
    throw CaseError(fmt::format("expected at most {} facets, found more", most_facets));
}

Triangles parse_ascii_stl(std::string_view text) {
  Triangles mesh;
  Words words(text);
  std::vector<Index> corners;
  while (words.next_line()) {
    const auto first = words.words()[0];
    if (first == "vertex") {
      corners.push_back(static_cast<Index>(mesh.points.size()));
      mesh.points.push_back(words.point(1));
    } else if (first == "endloop") {
      if (corners.size() != 3) wrong(words.where(), "three lines 'vertex' in a loop", std::to_string(corners.size()));
      add_polygon(corners, mesh);
      corners.clear();
    } else if (first != "solid" && first != "facet" && first != "outer" && first != "endfacet" && first != "endsolid") {
      wrong(words.where(), "a line of an ASCII STL (facet, outer loop, vertex, ..)", words.line());
    }
  }
  if (!corners.empty()) wrong(words.where(), "'endloop' before the end of the file", "its end");
  return mesh;
}

/// Reads numbers from bytes, whose order is reversed where the file's byte order differs from this machine's.
class Bytes {
 public:
  Bytes(std::string_view bytes, bool big_endian)
      : bytes_(bytes), swap_(big_endian != (std::endian::native == std::endian::big)) {}
  template <class T>
  T take(const char* what) {
    if (bytes_.size() < sizeof(T)) throw CaseError(fmt::format("the file ends amid {}", what));
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes_.data(), sizeof(T));
    if (swap_) std::reverse(raw.begin(), raw.end());
    bytes_.remove_prefix(sizeof(T));
    return std::bit_cast<T>(raw);
  }
  void skip(std::size_t n) { bytes_.remove_prefix(std::min(n, bytes_.size())); }

 private:
  std::string_view bytes_;
  bool swap_;
};

Triangles parse_binary_stl(std::string_view text) {
  constexpr std::size_t header = 80, row = 50;
  Bytes bytes(text, false);
  bytes.skip(header);
  const auto count = bytes.take<std::uint32_t>("the number of facets");
  if (text.size() < header + 4 + row * static_cast<std::size_t>(count) || count > most_facets)
    throw CaseError(
        fmt::format("a binary STL that announces {} facets: expected {} bytes and at most {} facets, found {} bytes",
                    count, header + 4 + row * static_cast<std::size_t>(count), most_facets, text.size()));
  Triangles mesh;
  for (std::uint32_t f = 0; f < count; ++f) {
    bytes.skip(3 * sizeof(float));
    for (int c = 0; c < 3; ++c) {
      Vec<3> x;
      for (int d = 0; d < 3; ++d) x[d] = static_cast<double>(bytes.take<float>("a facet"));
      if (!x.allFinite())
        wrong(fmt::format("facet {}", f + 1), "finite coordinates", fmt::format("{} {} {}", x.x(), x.y(), x.z()));
      mesh.points.push_back(x);
    }
    bytes.skip(2);
    const auto first = static_cast<Index>(3 * f);
    mesh.facets.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

Triangles parse_obj(std::string_view text) {
  Triangles mesh;
  Words words(text);
  std::vector<Index> corners;
  while (words.next_line()) {
    if (words.words()[0] == "v") mesh.points.push_back(words.point(1));
    if (words.words()[0] != "f") continue;
    corners.clear();
    for (std::size_t w = 1; w < words.words().size(); ++w) {
      const auto word = words.words()[w];
      long i = 0;
      const auto n = static_cast<long>(mesh.points.size());
      // Points are counted from 1 or, with negative numbers, back from the last point read so far.
      if (!Words::read(word.substr(0, word.find('/')), i) || i == 0 || i > n || i < -n)
        wrong(words.where(), fmt::format("numbers of points up to {}", n), words.line());
      corners.push_back(static_cast<Index>(i > 0 ? i - 1 : n + i));
    }
    if (corners.size() < 3) wrong(words.where(), "a facet of three points or more", words.line());
    add_polygon(corners, mesh);
  }
  return mesh;
}

/// A property of an element of a PLY file. `count`: for a list, the type of its length.
struct PlyProperty {
  std::string name, type, count;
};
struct PlyElement {
  std::string name;
  std::size_t size = 0;
  std::vector<PlyProperty> properties;
};

double take_ply(Bytes& bytes, const std::string& type) {
  constexpr const char* what = "an element";
  if (type == "char" || type == "int8") return bytes.take<std::int8_t>(what);
  if (type == "uchar" || type == "uint8") return bytes.take<std::uint8_t>(what);
  if (type == "short" || type == "int16") return bytes.take<std::int16_t>(what);
  if (type == "ushort" || type == "uint16") return bytes.take<std::uint16_t>(what);
  if (type == "int" || type == "int32") return bytes.take<std::int32_t>(what);
  if (type == "uint" || type == "uint32") return bytes.take<std::uint32_t>(what);
  if (type == "float" || type == "float32") return static_cast<double>(bytes.take<float>(what));
  if (type == "double" || type == "float64") return bytes.take<double>(what);
  throw CaseError(fmt::format("expected a type of PLY (float, int, uchar, ..), found '{}'", type));
}

Triangles parse_ply(std::string_view text) {
  Words words(text);
  std::vector<PlyElement> elements;
  std::string format;
  for (bool header = true; header;) {
    if (!words.next_line()) wrong(words.where(), "'end_header'", "the end of the file");
    const auto& w = words.words();
    if (w[0] == "format" && w.size() > 1) format = w[1];
    if (w[0] == "element") {
      PlyElement element;
      if (w.size() != 3 || !Words::read(w[2], element.size) || element.size > most_facets)
        wrong(words.where(), "element NAME COUNT", words.line());
      element.name = w[1];
      elements.push_back(element);
    }
    if (w[0] == "property") {
      const bool list = w.size() == 5 && w[1] == "list";
      if (elements.empty() || (!list && w.size() != 3)) wrong(words.where(), "property TYPE NAME", words.line());
      elements.back().properties.push_back(list ? PlyProperty{std::string(w[4]), std::string(w[3]), std::string(w[2])}
                                                : PlyProperty{std::string(w[2]), std::string(w[1]), ""});
    }
    header = w[0] != "end_header";
  }
  const bool ascii = format == "ascii";
  if (!ascii && format != "binary_little_endian" && format != "binary_big_endian")
    wrong("header", "format ascii, binary_little_endian or binary_big_endian", format);
  for (const auto& element : elements)
    if (element.properties.empty()) wrong("header", fmt::format("properties of '{}'", element.name), "none");
  Bytes bytes(words.rest(), format == "binary_big_endian");
  Triangles mesh;
  for (const auto& element : elements)
    for (std::size_t row = 0; row < element.size; ++row) {
      if (ascii && !words.next_line())
        wrong(words.where(), fmt::format("{} lines of '{}'", element.size, element.name), "the end of the file");
      std::size_t word = 0;
      const auto take = [&](const std::string& type) {
        return ascii ? words.number(word++, "a number") : take_ply(bytes, type);
      };
      Vec<3> x = Vec<3>::Constant(std::numeric_limits<double>::quiet_NaN());
      for (const auto& property : element.properties) {
        const double length = property.count.empty() ? 1.0 : take(property.count);
        if (!(length >= 0.0 && length <= 1e6))
          wrong(fmt::format("{} {}", element.name, row + 1), "a list of up to a million", fmt::format("{}", length));
        std::vector<Index> corners;
        for (std::size_t k = 0; k < static_cast<std::size_t>(length); ++k) {
          const double value = take(property.type);
          for (Eigen::Index d = 0; d < 3; ++d)
            if (property.name == std::string_view("xyz").substr(static_cast<std::size_t>(d), 1)) x[d] = value;
          if (property.count.empty()) continue;
          if (!(value >= 0.0 && value < static_cast<double>(mesh.points.size())) && element.name == "face")
            wrong(fmt::format("face {}", row + 1), fmt::format("numbers of points below {}", mesh.points.size()),
                  fmt::format("{}", value));
          corners.push_back(static_cast<Index>(value >= 0.0 && value < 4e9 ? value : 0.0));
        }
        if (element.name == "face" && property.name.starts_with("vertex_ind")) add_polygon(corners, mesh);
      }
      if (element.name != "vertex") continue;
      if (!x.allFinite())
        wrong(fmt::format("vertex {}", row + 1), "finite x, y and z", fmt::format("{} {} {}", x.x(), x.y(), x.z()));
      mesh.points.push_back(x);
    }
  return mesh;
}

/// Heights over a grid of points.
struct Heights {
  std::vector<double> x, y;  ///< m, increasing
  std::vector<double> z;     ///< m, [x + y * nx]
};

Heights parse_esri(std::string_view text) {
  Words words(text);
  std::optional<double> columns, rows, x0, y0, size, none;
  bool corner_x = false, corner_y = false;
  Heights heights;
  std::size_t i = 0, j = 0;  // row j from the top
  while (words.next_line()) {
    std::string key(words.words()[0]);
    std::transform(key.begin(), key.end(), key.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const auto header = [&](const char* name, std::optional<double>& value) {
      if (key != name) return false;
      value = words.number(1, "a number");
      return true;
    };
    corner_x = corner_x || key == "xllcorner";
    corner_y = corner_y || key == "yllcorner";
    if (header("ncols", columns) || header("nrows", rows) || header("xllcorner", x0) || header("xllcenter", x0) ||
        header("yllcorner", y0) || header("yllcenter", y0) || header("cellsize", size) || header("nodata_value", none))
      continue;
    if (heights.z.empty()) {
      const auto whole = [](const std::optional<double>& n) {
        return n && *n >= 2.0 && *n <= 1e5 && *n == std::floor(*n);
      };
      if (!whole(columns) || !whole(rows) || *columns * *rows > 0.25 * most_facets || !x0 || !y0 || !size ||
          !(*size > 0.0))
        wrong(words.where(), "before the heights: ncols and nrows (2 or more), xllcorner, yllcorner and cellsize",
              words.line());
      for (double c = 0; c < *columns; ++c) heights.x.push_back(*x0 + (c + (corner_x ? 0.5 : 0.0)) * *size);
      for (double r = 0; r < *rows; ++r) heights.y.push_back(*y0 + (r + (corner_y ? 0.5 : 0.0)) * *size);
      heights.z.resize(heights.x.size() * heights.y.size());
    }
    const std::size_t nx = heights.x.size(), ny = heights.y.size();
    for (std::size_t w = 0; w < words.words().size(); ++w) {
      const double z = words.number(w, "heights");
      if (j == ny) wrong(words.where(), fmt::format("{} rows of {} heights", ny, nx), "more");
      if (none && z == *none)
        throw CaseError(fmt::format("{}: no height at [{:.9g}, {:.9g}] m (NODATA_value); expected a height everywhere",
                                    words.where(), heights.x[i], heights.y[ny - 1 - j]));
      heights.z[i + nx * (ny - 1 - j)] = z;
      if (++i == nx) {
        i = 0;
        ++j;
      }
    }
  }
  if (heights.z.empty() || j != heights.y.size())
    wrong(words.where(), fmt::format("{} rows of {} heights", heights.y.size(), heights.x.size()),
          fmt::format("{} rows", j));
  return heights;
}

Heights parse_xyz(std::string_view text) {
  Words words(text);
  VecArray<3> points;
  while (words.next_line()) {
    if (words.words()[0].starts_with('#')) continue;
    points.push_back(words.point(0));
    if (points.size() > most_facets / 4) wrong(words.where(), "fewer points", "more than five million");
  }
  Heights heights;
  const auto distinct = [&](Eigen::Index d) {
    std::vector<double> values;
    for (const auto& p : points) values.push_back(p[d]);
    std::sort(values.begin(), values.end());
    // Files contain coordinates with few digits: values within this slack count as equal.
    const double slack = values.empty() ? 0.0 : 1e-6 * (values.back() - values.front());
    std::vector<double> result;
    for (const double v : values)
      if (result.empty() || v > result.back() + slack) result.push_back(v);
    return result;
  };
  heights.x = distinct(0);
  heights.y = distinct(1);
  const std::size_t nx = heights.x.size(), ny = heights.y.size();
  if (nx < 2 || ny < 2 || nx * ny > points.size())
    throw CaseError(fmt::format("expected points on a whole grid, one for each of {} x and {} y; found {} points", nx,
                                ny, points.size()));
  heights.z.assign(nx * ny, std::numeric_limits<double>::quiet_NaN());
  const auto place = [](const std::vector<double>& values, double v) {
    const auto above = static_cast<std::size_t>(std::upper_bound(values.begin(), values.end(), v) - values.begin());
    return above == 0 ? 0 : above - 1;
  };
  for (const auto& p : points) {
    double& z = heights.z[place(heights.x, p.x()) + nx * place(heights.y, p.y())];
    if (std::isfinite(z) && z != p.z())
      throw CaseError(
          fmt::format("two heights at [{:.9g}, {:.9g}] m, {} and {} m; expected one", p.x(), p.y(), z, p.z()));
    z = p.z();
  }
  for (std::size_t k = 0; k < heights.z.size(); ++k)
    if (!std::isfinite(heights.z[k]))
      throw CaseError(fmt::format("no height at [{:.9g}, {:.9g}] m; expected points on a whole grid", heights.x[k % nx],
                                  heights.y[k / nx]));
  return heights;
}

}  // namespace

Triangles parse_mesh(std::string_view text, std::string_view ending) {
  Triangles mesh;
  if (ending == ".stl") {
    // Binary files may begin with "solid", too; only they have zeros in their header.
    const bool ascii = text.starts_with("solid") && text.substr(0, 84).find('\0') == std::string_view::npos;
    mesh = ascii ? parse_ascii_stl(text) : parse_binary_stl(text);
  } else if (ending == ".obj") {
    mesh = parse_obj(text);
  } else if (ending == ".ply") {
    mesh = parse_ply(text);
  } else {
    throw CaseError(fmt::format("expected a file .stl, .obj or .ply, found '{}'", ending));
  }
  mesh = joined(mesh);
  if (mesh.facets.empty()) throw CaseError("expected triangles, found none");
  return mesh;
}

Triangles parse_terrain(std::string_view text, std::string_view ending, double bottom) {
  if (ending != ".asc" && ending != ".xyz")
    throw CaseError(fmt::format("expected a file .asc or .xyz, found '{}'", ending));
  const Heights heights = ending == ".asc" ? parse_esri(text) : parse_xyz(text);
  const auto nx = static_cast<Index>(heights.x.size()), ny = static_cast<Index>(heights.y.size());
  Triangles body;
  for (const bool top : {true, false})
    for (Index j = 0; j < ny; ++j)
      for (Index i = 0; i < nx; ++i) {
        const double z = heights.z[i + static_cast<std::size_t>(nx) * j];
        if (!(z > bottom))
          throw CaseError(fmt::format("the terrain is at {} m at [{:.9g}, {:.9g}] m; expected it above 'bottom', {} m",
                                      z, heights.x[i], heights.y[j], bottom));
        body.points.emplace_back(heights.x[i], heights.y[j], top ? z : bottom);
      }
  const auto quad = [&](Index a, Index b, Index c, Index d) {
    body.facets.push_back({a, b, c});
    body.facets.push_back({a, c, d});
  };
  const Index below = nx * ny;
  const auto at = [&](Index i, Index j) { return i + nx * j; };
  for (Index j = 0; j + 1 < ny; ++j)
    for (Index i = 0; i + 1 < nx; ++i) {
      quad(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      quad(below + at(i, j), below + at(i, j + 1), below + at(i + 1, j + 1), below + at(i + 1, j));
    }
  const auto side = [&](Index a, Index b) { quad(a, below + a, below + b, b); };
  for (Index i = 0; i + 1 < nx; ++i) {
    side(at(i, 0), at(i + 1, 0)), side(at(i + 1, ny - 1), at(i, ny - 1));
  }
  for (Index j = 0; j + 1 < ny; ++j) {
    side(at(nx - 1, j), at(nx - 1, j + 1)), side(at(0, j + 1), at(0, j));
  }
  return body;
}

}  // namespace poretwin
