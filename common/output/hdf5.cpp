#include "common/output/hdf5.hpp"

#include "common/core/error.hpp"
#include "common/output/undo_driver.hpp"

#include <fmt/format.h>
#include <hdf5.h>

#include <algorithm>
#include <utility>

namespace poretwin::hdf5 {
namespace {

static_assert(sizeof(hid_t) == sizeof(Id::Value));

int close_file(Id::Value id) { return H5Fclose(id); }
int close_object(Id::Value id) { return H5Oclose(id); }
int close_space(Id::Value id) { return H5Sclose(id); }
int close_type(Id::Value id) { return H5Tclose(id); }
int close_properties(Id::Value id) { return H5Pclose(id); }
int close_attribute(Id::Value id) { return H5Aclose(id); }

/// The innermost entry of the library's error stack is the cause ("No space left on device").
std::string cause() {
  std::string text;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned n, const H5E_error2_t* error, void* data) -> herr_t {
        if (n == 0 && error->desc != nullptr) *static_cast<std::string*>(data) = error->desc;
        return 0;
      },
      &text);
  return text.empty() ? "no cause given" : text;
}

/// The system's message on the first failed write to the file: the library's error stack may name a later failure only.
std::string cause_at(Id::Value object) {
  const std::string latest = cause();  // must precede the next call, which clears the stack
  const std::string lost = object >= 0 ? undo_failure(object) : std::string();
  return lost.empty() ? latest : lost;
}

Id::Value disk_type(Type type) {
  switch (type) {
    case Type::float64:
      return H5T_IEEE_F64LE;
    case Type::int64:
      return H5T_STD_I64LE;
    case Type::uint8:
      return H5T_STD_U8LE;
  }
  return -1;
}

}  // namespace

Id::Id(Id&& other) noexcept : value_(std::exchange(other.value_, -1)), close_(other.close_) {}

Id& Id::operator=(Id&& other) noexcept {
  if (this != &other) {
    reset();
    value_ = std::exchange(other.value_, -1);
    close_ = other.close_;
  }
  return *this;
}

void Id::reset() noexcept {
  if (value_ >= 0 && close_ != nullptr) close_(value_);
  value_ = -1;
}

File::File(const std::filesystem::path& path, Mode mode) : path_(path.string()) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const Id access = check(H5Pcreate(H5P_FILE_ACCESS), close_properties, "preparing to open");
  H5Pset_file_locking(access.get(), false, true);
  if (mode == Mode::write) roll_back(path);
  if (mode != Mode::read) check(H5Pset_driver(access.get(), undo_driver(), nullptr), "preparing to open");
  if (mode == Mode::create)
    id_ = check(H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), close_file, "creating");
  else
    id_ = check(H5Fopen(path_.c_str(), mode == Mode::write ? H5F_ACC_RDWR : H5F_ACC_RDONLY, access.get()), close_file,
                "opening");
}

File File::create(const std::filesystem::path& path) { return File(path, Mode::create); }
File File::open_to_read(const std::filesystem::path& path) { return File(path, Mode::read); }
File File::open_to_write(const std::filesystem::path& path) { return File(path, Mode::write); }

void File::fail(const std::string& action) const {
  throw FileError(fmt::format("{}: {} failed: {}", path_, action, cause_at(id_.get())));
}

Id File::check(Id::Value value, Id::Close close, const std::string& action) const {
  if (value < 0) fail(action);
  return {value, close};
}

void File::check(int status, const std::string& action) const {
  if (status < 0) fail(action);
}

void File::group(const std::string& name) {
  const Id links = check(H5Pcreate(H5P_LINK_CREATE), close_properties, "creating group " + name);
  H5Pset_create_intermediate_group(links.get(), 1);
  const Id made = check(H5Gcreate2(id_.get(), name.c_str(), links.get(), H5P_DEFAULT, H5P_DEFAULT), close_object,
                        "creating group " + name);
}

/// Cache settings for one chunk: appending needs only the last chunk of a data set; the default cache is 1 MB for each.
Id File::cache_of_a_chunk(const std::string& action) const {
  constexpr std::size_t bytes = std::size_t{1} << 17;
  Id access = check(H5Pcreate(H5P_DATASET_ACCESS), close_properties, action);
  check(H5Pset_chunk_cache(access.get(), H5D_CHUNK_CACHE_NSLOTS_DEFAULT, bytes, H5D_CHUNK_CACHE_W0_DEFAULT), action);
  return access;
}

Dataset File::dataset(const std::string& name, Type type, std::size_t columns, std::size_t chunk_rows) {
  const std::string action = "creating data set " + name;
  const int rank = columns == 0 ? 1 : 2;
  const hsize_t size[2] = {0, columns}, most[2] = {H5S_UNLIMITED, columns};
  const hsize_t chunk[2] = {std::max<hsize_t>(1, chunk_rows), columns};
  const Id space = check(H5Screate_simple(rank, size, most), close_space, action), access = cache_of_a_chunk(action);
  const Id properties = check(H5Pcreate(H5P_DATASET_CREATE), close_properties, action);
  check(H5Pset_chunk(properties.get(), rank, chunk), action);
  check(H5Pset_shuffle(properties.get()), action);
  check(H5Pset_deflate(properties.get(), 1), action);
  Dataset result;
  result.id_ = check(
      H5Dcreate2(id_.get(), name.c_str(), disk_type(type), space.get(), H5P_DEFAULT, properties.get(), access.get()),
      close_object, action);
  result.columns_ = columns;
  result.what_ = path_ + ": " + name;
  return result;
}

Dataset File::cut_dataset(const std::string& name, std::size_t rows) {
  const auto size = shape(name);
  if (size.empty() || size.front() < rows)
    throw FileError(
        fmt::format("{}: {}: expected at least {} rows, found {}", path_, name, rows, size.empty() ? 0 : size.front()));
  Dataset result;
  const std::string action = "opening data set " + name;
  const Id access = cache_of_a_chunk(action);
  result.id_ = check(H5Dopen2(id_.get(), name.c_str(), access.get()), close_object, action);
  result.columns_ = size.size() > 1 ? size[1] : 0;
  result.rows_ = rows;
  result.what_ = path_ + ": " + name;
  const hsize_t cut[2] = {rows, result.columns_};
  check(H5Dset_extent(result.id_.get(), cut), "cutting data set " + name);
  return result;
}

void File::remove(const std::string& name) {
  check(H5Ldelete(id_.get(), name.c_str(), H5P_DEFAULT), "removing " + name);
}

void Dataset::append_raw(const void* data, std::size_t count, Id::Value memory_type) {
  if (count == 0) return;
  const std::size_t columns = std::max<std::size_t>(1, columns_), added = count / columns;
  if (added * columns != count)
    throw FileError(fmt::format("{}: {} values do not fill rows of {}", what_, count, columns));
  const int rank = columns_ == 0 ? 1 : 2;
  const hsize_t size[2] = {rows_ + added, columns}, start[2] = {rows_, 0}, block[2] = {added, columns};
  bool good = H5Dset_extent(id_.get(), size) >= 0;
  if (good) {
    const Id file_space(H5Dget_space(id_.get()), close_space),
        memory_space(H5Screate_simple(rank, block, nullptr), close_space);
    good = file_space.get() >= 0 && memory_space.get() >= 0 &&
           H5Sselect_hyperslab(file_space.get(), H5S_SELECT_SET, start, nullptr, block, nullptr) >= 0 &&
           H5Dwrite(id_.get(), memory_type, memory_space.get(), file_space.get(), H5P_DEFAULT, data) >= 0;
  }
  if (!good || !undo_failure(id_.get()).empty())
    throw FileError(fmt::format("{}: writing failed: {}", what_, cause_at(id_.get())));
  rows_ += added;
}

void Dataset::append(std::span<const double> values) { append_raw(values.data(), values.size(), H5T_NATIVE_DOUBLE); }
void Dataset::append(std::span<const std::int64_t> values) {
  append_raw(values.data(), values.size(), H5T_NATIVE_INT64);
}
void Dataset::append(std::span<const std::uint8_t> values) {
  append_raw(values.data(), values.size(), H5T_NATIVE_UINT8);
}

void File::attribute(const std::string& object, const std::string& name, const std::string& text) {
  const std::string action = fmt::format("writing attribute {} of {}", name, object);
  const Id type = check(H5Tcopy(H5T_C_S1), close_type, action);
  check(H5Tset_size(type.get(), std::max<std::size_t>(1, text.size())), action);
  check(H5Tset_strpad(type.get(), H5T_STR_NULLPAD), action);
  const Id space = check(H5Screate(H5S_SCALAR), close_space, action);
  const Id owner = check(H5Oopen(id_.get(), object.c_str(), H5P_DEFAULT), close_object, action);
  const Id made = check(H5Acreate2(owner.get(), name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT),
                        close_attribute, action);
  const std::string padded = text.empty() ? std::string(1, '\0') : text;
  check(H5Awrite(made.get(), type.get(), padded.data()), action);
}

void File::attribute(const std::string& object, const std::string& name, std::span<const std::int64_t> values) {
  const std::string action = fmt::format("writing attribute {} of {}", name, object);
  const hsize_t size = values.size();
  const Id space = check(H5Screate_simple(1, &size, nullptr), close_space, action);
  const Id owner = check(H5Oopen(id_.get(), object.c_str(), H5P_DEFAULT), close_object, action);
  const Id made = check(H5Acreate2(owner.get(), name.c_str(), H5T_STD_I64LE, space.get(), H5P_DEFAULT, H5P_DEFAULT),
                        close_attribute, action);
  check(H5Awrite(made.get(), H5T_NATIVE_INT64, values.data()), action);
}

void File::attribute(const std::string& object, const std::string& name, std::int64_t value) {
  const std::string action = fmt::format("writing attribute {} of {}", name, object);
  const Id owner = check(H5Oopen(id_.get(), object.c_str(), H5P_DEFAULT), close_object, action);
  Id made;
  if (H5Aexists(owner.get(), name.c_str()) > 0) {
    made = check(H5Aopen(owner.get(), name.c_str(), H5P_DEFAULT), close_attribute, action);
  } else {
    const Id space = check(H5Screate(H5S_SCALAR), close_space, action);
    made = check(H5Acreate2(owner.get(), name.c_str(), H5T_STD_I64LE, space.get(), H5P_DEFAULT, H5P_DEFAULT),
                 close_attribute, action);
  }
  check(H5Awrite(made.get(), H5T_NATIVE_INT64, &value), action);
}

void File::text(const std::string& name, const std::string& value) {
  const std::string action = "writing " + name;
  const Id type = check(H5Tcopy(H5T_C_S1), close_type, action);
  check(H5Tset_size(type.get(), std::max<std::size_t>(1, value.size())), action);
  check(H5Tset_cset(type.get(), H5T_CSET_UTF8), action);
  check(H5Tset_strpad(type.get(), H5T_STR_NULLPAD), action);
  const Id space = check(H5Screate(H5S_SCALAR), close_space, action);
  const Id made =
      check(H5Dcreate2(id_.get(), name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
            close_object, action);
  const std::string padded = value.empty() ? std::string(1, '\0') : value;
  check(H5Dwrite(made.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, padded.data()), action);
}

void File::flush() {
  check(H5Fflush(id_.get(), H5F_SCOPE_GLOBAL), "flushing");
  if (!undo_failure(id_.get()).empty()) fail("flushing");
}

bool File::has(const std::string& name) const { return H5Lexists(id_.get(), name.c_str(), H5P_DEFAULT) > 0; }

std::vector<std::string> File::names(const std::string& group) const {
  std::vector<std::string> result;
  const Id owner = check(H5Gopen2(id_.get(), group.c_str(), H5P_DEFAULT), close_object, "opening group " + group);
  check(H5Literate(
            owner.get(), H5_INDEX_NAME, H5_ITER_INC, nullptr,
            [](hid_t, const char* name, const H5L_info_t*, void* data) -> herr_t {
              static_cast<std::vector<std::string>*>(data)->emplace_back(name);
              return 0;
            },
            &result),
        "listing group " + group);
  return result;
}

std::vector<std::size_t> File::shape(const std::string& dataset) const {
  const Id data = check(H5Dopen2(id_.get(), dataset.c_str(), H5P_DEFAULT), close_object, "opening data set " + dataset);
  const Id space = check(H5Dget_space(data.get()), close_space, "reading " + dataset);
  std::vector<hsize_t> size(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space.get()))));
  H5Sget_simple_extent_dims(space.get(), size.data(), nullptr);
  return {size.begin(), size.end()};
}

std::vector<double> File::read_numbers(const std::string& dataset) const {
  std::size_t count = 1;
  for (const auto n : shape(dataset)) count *= n;
  std::vector<double> values(count);
  const Id data = check(H5Dopen2(id_.get(), dataset.c_str(), H5P_DEFAULT), close_object, "opening data set " + dataset);
  if (count > 0)
    check(H5Dread(data.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), "reading " + dataset);
  return values;
}

std::vector<double> File::read_rows(const std::string& dataset, std::size_t first, std::size_t count) const {
  const auto size = shape(dataset);
  if (size.empty() || size.size() > 2 || size.front() < first + count)
    throw FileError(fmt::format("{}: {}: expected at least {} rows, found {}", path_, dataset, first + count,
                                size.empty() ? 0 : size.front()));
  const std::string action = "reading " + dataset;
  const hsize_t columns = size.size() > 1 ? size[1] : 1;
  const hsize_t start[2] = {first, 0}, block[2] = {count, columns};
  const int rank = static_cast<int>(size.size());
  std::vector<double> values(count * columns);
  if (values.empty()) return values;
  const Id data = check(H5Dopen2(id_.get(), dataset.c_str(), H5P_DEFAULT), close_object, "opening data set " + dataset);
  const Id in_file = check(H5Dget_space(data.get()), close_space, action);
  const Id in_memory = check(H5Screate_simple(rank, block, nullptr), close_space, action);
  check(H5Sselect_hyperslab(in_file.get(), H5S_SELECT_SET, start, nullptr, block, nullptr), action);
  check(H5Dread(data.get(), H5T_NATIVE_DOUBLE, in_memory.get(), in_file.get(), H5P_DEFAULT, values.data()), action);
  return values;
}

std::vector<std::int64_t> File::read_integers(const std::string& dataset) const {
  std::size_t count = 1;
  for (const auto n : shape(dataset)) count *= n;
  std::vector<std::int64_t> values(count);
  const Id data = check(H5Dopen2(id_.get(), dataset.c_str(), H5P_DEFAULT), close_object, "opening data set " + dataset);
  if (count > 0)
    check(H5Dread(data.get(), H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), "reading " + dataset);
  return values;
}

std::string File::read_text(const std::string& dataset) const {
  const std::string action = "reading " + dataset;
  const Id data = check(H5Dopen2(id_.get(), dataset.c_str(), H5P_DEFAULT), close_object, action);
  const Id type = check(H5Dget_type(data.get()), close_type, action);
  std::string value(H5Tget_size(type.get()), '\0');
  check(H5Dread(data.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, value.data()), action);
  return value;
}

std::string File::attribute_text(const std::string& object, const std::string& name) const {
  const std::string action = fmt::format("reading attribute {} of {}", name, object);
  const Id attribute = check(H5Aopen_by_name(id_.get(), object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                             close_attribute, action);
  const Id type = check(H5Aget_type(attribute.get()), close_type, action);
  std::string value(H5Tget_size(type.get()), '\0');
  check(H5Aread(attribute.get(), type.get(), value.data()), action);
  return value;
}

std::vector<std::int64_t> File::attribute_integers(const std::string& object, const std::string& name) const {
  const std::string action = fmt::format("reading attribute {} of {}", name, object);
  const Id attribute = check(H5Aopen_by_name(id_.get(), object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                             close_attribute, action);
  const Id space = check(H5Aget_space(attribute.get()), close_space, action);
  std::vector<std::int64_t> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get())));
  check(H5Aread(attribute.get(), H5T_NATIVE_INT64, values.data()), action);
  return values;
}

bool File::is_float64(const std::string& dataset) const {
  const Id data = check(H5Dopen2(id_.get(), dataset.c_str(), H5P_DEFAULT), close_object, "opening data set " + dataset);
  const Id type = check(H5Dget_type(data.get()), close_type, "reading " + dataset);
  return H5Tequal(type.get(), H5T_IEEE_F64LE) > 0;
}

}  // namespace poretwin::hdf5
