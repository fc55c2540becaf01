// Bodies in 3D: what closed surfaces enclose, less what is cut out of it.
#pragma once

#include "common/case/case.hpp"
#include "common/geometry/triangle_mesh.hpp"

#include <functional>
#include <memory>
#include <string>

namespace poretwin {

class Solid {
 public:
  /// A surface inside which the body lies, or, `cut_out`, outside which it does.
  struct Part {
    TriangleMesh mesh;
    bool cut_out = false;
    /// Distance from the surface [m], positive on the body's side; of what is farther than a range: the range.
    [[nodiscard]] double depth(const Point3& x, double range) const {
      return cut_out ? -mesh.depth(x, range) : mesh.depth(x, range);
    }
    [[nodiscard]] bool contains(const Point3& x) const { return mesh.contains(x) != cut_out; }
  };
  /// What all parts have in common, the first not cut out; resolution [m]: of its volume, where there are several.
  Solid(std::vector<Part> parts, double resolution);

  [[nodiscard]] bool contains(const Point3& x) const;
  /// Distance from the border [m], positive inside, of what is farther than a range: the range; of several parts a
  /// lower bound of it outside.
  [[nodiscard]] double depth(const Point3& x, double range) const;
  [[nodiscard]] const std::vector<Part>& parts() const { return parts_; }
  [[nodiscard]] double volume() const { return volume_; }  ///< m3
  [[nodiscard]] const std::pair<Point3, Point3>& bounds() const { return bounds_; }
  /// Lowest and highest of x . direction [m].
  [[nodiscard]] std::pair<double, double> extent(const Point3& direction) const;
  [[nodiscard]] Solid moved(const Point3& way) const;

 private:
  std::vector<Part> parts_;
  double resolution_ = 0.0, volume_ = 0.0;
  std::pair<Point3, Point3> bounds_;
};

/// The surface of a shape without what it is cut by, placed; curved ones to within a small part of a spacing [m], with
/// their own volume. read(file): the text of a file. Throws CaseError with what is wrong with the shape.
Triangles surface_of(const Shape& shape, double spacing, const std::function<std::string(const std::string&)>& read);

/// A point of a shape, where its placement puts it.
Point3 placed(const Placement& placement, const Point3& x, int dimension);

}  // namespace poretwin
