#include "common/output/vtkhdf.hpp"

#include "common/core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>

namespace poretwin {
namespace {

constexpr std::size_t particle_chunk = 16384, step_chunk = 256;
constexpr std::uint8_t vtk_vertex = 1;

std::string components_of(const FieldDeclaration& field) {
  if (field.components == 3) return "x y z";
  if (field.components == 6) return "xx yy zz xy yz xz";
  return "scalar";
}

std::string_view xdmf_type(int components) {
  if (components == 3) return "Vector";
  if (components == 6) return "Matrix";  // of Tensor6, XDMF2 would make nine components in another order
  return "Scalar";
}

/// Appends one row.
void append_one(hdf5::Dataset& data, std::int64_t value) { data.append(std::span<const std::int64_t>(&value, 1)); }

/// Appends `count` rows of `columns` numbers, a chunk at a time; write(i, numbers) writes row i to `numbers`.
template <class Number, class Write>
void append_rows(hdf5::Dataset& data, std::size_t count, std::size_t columns, const Write& write) {
  const std::size_t rows = std::min(count, particle_chunk / columns);
  std::vector<Number> numbers(rows * columns);
  for (std::size_t first = 0; first < count; first += rows) {
    const std::size_t chunk = std::min(rows, count - first);
    for (std::size_t i = 0; i < chunk; ++i) write(first + i, &numbers[i * columns]);
    data.append(std::span<const Number>(numbers.data(), chunk * columns));
  }
}

/// Part of a data set in a form that both ParaView readers understand. XDMF3 reads the text
/// ("start:stride:count:whole") and does not know "Hyperslab"; XDMF2 reads the items below the text and ignores the
/// text itself.
std::string slab(const std::string& file, const std::string& name, const std::string& number_type, std::int64_t first,
                 std::int64_t count, std::int64_t total, int columns) {
  const bool wide = columns > 1;
  const auto size = [&](std::int64_t n) { return wide ? fmt::format("{} {}", n, columns) : fmt::format("{}", n); };
  const std::string start = wide ? fmt::format("{} 0", first) : fmt::format("{}", first);
  const std::string stride = wide ? "1 1" : "1";
  const std::string form = fmt::format("NumberType=\"{}\" Precision=\"8\" Format=\"HDF\"", number_type);
  const std::string whole = fmt::format("{}:/VTKHDF/{}", file, name);
  // For an empty part, XDMF3 would divide by zero; it accepts an empty text for no rows.
  const std::string own = count > 0
                              ? fmt::format("{}>{}|{}:{}:{}:{}", form, whole, start, stride, size(count), size(total))
                              : fmt::format("NumberType=\"{}\" Precision=\"8\" Format=\"XML\">", number_type);
  return fmt::format(
      "        <DataItem ItemType=\"Hyperslab\" Dimensions=\"{}\" {}\n"
      "          <DataItem Dimensions=\"3 {}\" Format=\"XML\">{} {} {}</DataItem>\n"
      "          <DataItem Dimensions=\"{}\" {}>{}</DataItem>\n"
      "        </DataItem>\n",
      size(count), own, wide ? 2 : 1, start, stride, size(count), size(total), form, whole);
}

}  // namespace

VtkHdfWriter::VtkHdfWriter(const std::filesystem::path& path) : path_(path), file_(hdf5::File::create(path)) {
  file_.group("VTKHDF");
  constexpr std::array<std::int64_t, 2> version{2, 0};
  file_.attribute("VTKHDF", "Version", version);
  file_.attribute("VTKHDF", "Type", "UnstructuredGrid");
  file_.group("VTKHDF/PointData");
  file_.group("VTKHDF/Steps");
  file_.group("VTKHDF/Steps/PointDataOffsets");
  file_.attribute("VTKHDF/Steps", "NSteps", std::int64_t{0});
  bind(true);
  file_.attribute("VTKHDF/Points", "unit", "m");
  file_.attribute("VTKHDF/Points", "description", "Positions of the particles");
  file_.attribute("VTKHDF/Steps/Values", "unit", "s");
  file_.attribute("VTKHDF/Steps/Values", "description", "Simulated time");
  file_.flush();
}

VtkHdfWriter::VtkHdfWriter(const std::filesystem::path& path, Archive& checkpoint)
    : path_(path), file_(hdf5::File::open_to_write(path)) {
  archive(checkpoint);
  file_.attribute("VTKHDF/Steps", "NSteps", static_cast<std::int64_t>(steps_.size()));
  bind(false);
  bind_columns(false);
  file_.flush();
  write_sidecar();
}

void VtkHdfWriter::archive(Archive& archive) { archive(steps_, total_, columns_); }

void VtkHdfWriter::bind(bool create) {
  using hdf5::Type;
  const std::size_t steps = steps_.size(), particles = static_cast<std::size_t>(total_);
  const auto set = [&](hdf5::Dataset& data, const std::string& name, Type type, std::size_t columns, std::size_t chunk,
                       std::size_t rows) {
    const std::string full = "VTKHDF/" + name;
    data = create ? file_.dataset(full, type, columns, chunk) : file_.cut_dataset(full, rows);
  };
  set(number_of_points_, "NumberOfPoints", Type::int64, 0, step_chunk, steps);
  set(number_of_cells_, "NumberOfCells", Type::int64, 0, step_chunk, steps);
  set(number_of_ids_, "NumberOfConnectivityIds", Type::int64, 0, step_chunk, steps);
  set(points_, "Points", Type::float64, 3, particle_chunk / 3, particles);
  set(connectivity_, "Connectivity", Type::int64, 0, particle_chunk, particles);
  set(offsets_, "Offsets", Type::int64, 0, particle_chunk, particles + steps);
  set(types_, "Types", Type::uint8, 0, particle_chunk, particles);
  set(times_, "Steps/Values", Type::float64, 0, step_chunk, steps);
  set(part_offsets_, "Steps/PartOffsets", Type::int64, 0, step_chunk, steps);
  set(parts_, "Steps/NumberOfParts", Type::int64, 0, step_chunk, steps);
  set(point_offsets_, "Steps/PointOffsets", Type::int64, 0, step_chunk, steps);
  set(cell_offsets_, "Steps/CellOffsets", Type::int64, 1, step_chunk, steps);
  set(id_offsets_, "Steps/ConnectivityIdOffsets", Type::int64, 1, step_chunk, steps);
}

void VtkHdfWriter::bind_columns(bool create) {
  for (auto& column : columns_) {
    const auto& field = column.declaration;
    const std::string name = "VTKHDF/PointData/" + field.name, offsets = "VTKHDF/Steps/PointDataOffsets/" + field.name;
    if (!create) {
      column.values = file_.cut_dataset(name, static_cast<std::size_t>(total_));
      column.offsets = file_.cut_dataset(offsets, steps_.size());
      continue;
    }
    const auto columns = field.components == 1 ? std::size_t{0} : static_cast<std::size_t>(field.components);
    column.values =
        file_.dataset(name, hdf5::Type::float64, columns, particle_chunk / std::max<std::size_t>(1, columns));
    column.offsets = file_.dataset(offsets, hdf5::Type::int64, 0, step_chunk);
    file_.attribute(name, "unit", field.unit);
    file_.attribute(name, "description", field.description);
    file_.attribute(name, "components", components_of(field));
  }
}

std::filesystem::path VtkHdfWriter::sidecar() const {
  auto path = path_;
  return path.replace_extension(".xmf");
}

void VtkHdfWriter::declare(const OutputFrame& frame) {
  for (const auto& field : frame.fields) {
    if (field.name.empty() || field.name.find_first_of("/.") != std::string::npos)
      throw FileError(fmt::format("{}: field name '{}' is empty or holds '/' or '.', which VTKHDF readers cannot take",
                                  path_.string(), field.name));
    Column column;
    column.declaration = field;
    columns_.push_back(std::move(column));
  }
  bind_columns(true);
}

void VtkHdfWriter::check(const OutputFrame& frame) const {
  if (frame.fields.size() != columns_.size())
    throw FileError(fmt::format("{}: a frame of {} fields does not fit a file of {} fields", path_.string(),
                                frame.fields.size(), columns_.size()));
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const auto& field = frame.fields[i];
    const auto& declared = columns_[i].declaration;
    if (field.name != declared.name || field.components != declared.components)
      throw FileError(fmt::format("{}: field '{}' of {} components does not fit '{}' of {}", path_.string(), field.name,
                                  field.components, declared.name, declared.components));
  }
}

void VtkHdfWriter::append(const OutputFrame& frame) {
  if (steps_.empty()) declare(frame);
  check(frame);
  const std::size_t n = frame.count;
  const auto count = static_cast<std::int64_t>(n), first = total_, step = static_cast<std::int64_t>(steps_.size());

  const auto number = [](std::size_t i, std::int64_t* itself) { *itself = static_cast<std::int64_t>(i); };
  append_rows<double>(points_, n, 3, frame.position);
  append_rows<std::int64_t>(connectivity_, n, 1, number);
  // Each step has one more offset than it has cells, even without cells.
  append_rows<std::int64_t>(offsets_, n + 1, 1, number);
  append_rows<std::uint8_t>(types_, n, 1, [](std::size_t, std::uint8_t* type) { *type = vtk_vertex; });
  for (std::size_t k = 0; k < columns_.size(); ++k)
    append_rows<double>(columns_[k].values, n, static_cast<std::size_t>(frame.fields[k].components),
                        frame.fields[k].write);
  for (auto* counter : {&number_of_points_, &number_of_cells_, &number_of_ids_}) append_one(*counter, count);

  times_.append(std::span<const double>(&frame.time, 1));
  append_one(part_offsets_, step);
  append_one(parts_, 1);
  for (auto* offset : {&point_offsets_, &cell_offsets_, &id_offsets_}) append_one(*offset, first);
  for (auto& column : columns_) append_one(column.offsets, first);

  steps_.push_back({frame.time, count, first});
  total_ += count;
  try {
    file_.attribute("VTKHDF/Steps", "NSteps", static_cast<std::int64_t>(steps_.size()));
    file_.flush();
  } catch (...) {  // the data file is back at the last frame; so must the side-car be
    steps_.pop_back();
    total_ -= count;
    throw;
  }
  constexpr std::size_t always = 64;
  if (steps_.size() <= always || 16 * (steps_.size() - in_sidecar_) >= in_sidecar_) write_sidecar();
}

VtkHdfWriter::~VtkHdfWriter() {
  try {
    if (in_sidecar_ < steps_.size()) write_sidecar();
  } catch (const std::exception&) {  // the data are complete without the side-car
  }
}

void VtkHdfWriter::write_sidecar() {
  const std::string file = path_.filename().string();
  std::string text =
      "<?xml version=\"1.0\"?>\n<Xdmf Version=\"2.0\">\n<Domain>\n"
      "  <Grid Name=\"particles\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  for (const auto& step : steps_) {
    const auto piece = [&](const std::string& name, const char* number_type, int columns) {
      return slab(file, name, number_type, step.first, step.points, total_, columns);
    };
    // Without this grid, a step without particles would show the particles of another step. XDMF2 needs a geometry,
    // which has no rows here.
    text += fmt::format(
        "    <Grid Name=\"particles\" GridType=\"Uniform\">\n      <Time Value=\"{:.17g}\"/>\n"
        "      <Topology TopologyType=\"Polyvertex\" NumberOfElements=\"{}\" NodesPerElement=\"1\">\n{}      "
        "</Topology>\n"
        "      <Geometry GeometryType=\"XYZ\">\n{}      </Geometry>\n",
        step.time, step.points, step.points > 0 ? piece("Connectivity", "Int", 1) : "", piece("Points", "Float", 3));
    for (const auto& column : columns_) {
      if (step.points == 0) break;
      text += fmt::format("      <Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"Node\">\n{}      </Attribute>\n",
                          column.declaration.name, xdmf_type(column.declaration.components),
                          piece("PointData/" + column.declaration.name, "Float", column.declaration.components));
    }
    text += "    </Grid>\n";
  }
  text += "  </Grid>\n</Domain>\n</Xdmf>\n";
  const auto target = sidecar();
  auto fresh = target;
  fresh += ".new";
  std::ofstream stream(fresh, std::ios::binary);
  stream << text;
  stream.close();
  std::error_code error;
  if (stream) std::filesystem::rename(fresh, target, error);
  if (!stream || error)
    throw FileError(fmt::format("{}: cannot be written (disk full or folder gone?)", target.string()));
  in_sidecar_ = steps_.size();
}

}  // namespace poretwin
