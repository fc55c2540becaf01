// Bodies in 3D: the space inside closed surfaces, minus what is cut out of it.
#pragma once

#include "common/case/case.hpp"
#include "common/geometry/triangle_mesh.hpp"

#include <functional>
#include <memory>
#include <string>

namespace poretwin {

class Solid {
 public:
  /// A surface inside which the body lies or, if `cut_out`, outside which it lies.
  struct Part {
    TriangleMesh mesh;
    bool cut_out = false;
    /// Distance from the surface [m], positive on the body's side, bounded by +- range.
    [[nodiscard]] double depth(const Point3& x, double range) const {
      return cut_out ? -mesh.depth(x, range) : mesh.depth(x, range);
    }
    [[nodiscard]] bool contains(const Point3& x) const { return mesh.contains(x) != cut_out; }
  };
  /// The intersection of all parts. The first part is not cut out. resolution [m]: size of the cells with which the
  /// volume of several parts is computed.
  Solid(std::vector<Part> parts, double resolution);

  [[nodiscard]] bool contains(const Point3& x) const;
  /// Distance from the body's surface [m], positive inside, bounded by +- range. Outside a body of several parts, its
  /// magnitude is a lower bound of the distance.
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

/// The surface of a shape in its final place, before other shapes cut it. Facets of curved surfaces depart from the
/// surfaces by a hundredth of a spacing [m]; the enclosed volume is exact. read(file): the text of a file. Throws
/// CaseError with the fault of the shape.
Triangles surface_of(const Shape& shape, double spacing, const std::function<std::string(const std::string&)>& read);

/// A point of a shape after it has been scaled, turned and moved.
Point3 placed(const Placement& placement, const Point3& x, int dimension);

}  // namespace poretwin
