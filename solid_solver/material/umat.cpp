#include "solid_solver/material/umat.hpp"

#include "common/core/error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <dlfcn.h>
#include <array>
#include <filesystem>
#include <limits>

namespace poretwin::solid {
namespace {

/// SUBROUTINE UMAT with its arguments in the order of Abaqus, as compiled by gfortran and Intel's compiler, or in C++
/// with extern "C". The length of the material's name is the last argument.
using Function = void (*)(double* stress, double* statev, double* ddsdde, double* sse, double* spd, double* scd,
                          double* rpl, double* ddsddt, double* drplde, double* drpldt, const double* stran,
                          const double* dstran, const double* time, const double* dtime, const double* temp,
                          const double* dtemp, const double* predef, const double* dpred, const char* cmname,
                          const int* ndi, const int* nshr, const int* ntens, const int* nstatv, const double* props,
                          const int* nprops, const double* coords, const double* drot, double* pnewdt,
                          const double* celent, const double* dfgrd0, const double* dfgrd1, const int* noel,
                          const int* npt, const int* layer, const int* kspt, const int* kstep, const int* kinc,
                          std::size_t length);

/// Abaqus orders components 11 22 33 12 13 23, Tensor xx yy zz xy yz xz.
constexpr std::array<Eigen::Index, 6> place{0, 1, 2, 3, 5, 4};

/// Finds the library's function, or the reason why there is none. Libraries remain open until the program ends.
std::pair<void*, std::string> find_function(const std::string& library) {
  const std::string path = std::filesystem::absolute(library).string();
  void* const opened = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (opened == nullptr) return {nullptr, dlerror()};
  void* const function = dlsym(opened, "umat_");
  if (function == nullptr)
    return {nullptr, fmt::format("{} has no function umat_: expected SUBROUTINE UMAT in Fortran, or extern \"C\" void "
                                 "umat_(..) in C++",
                                 path)};
  return {function, ""};
}

}  // namespace

struct Umat::Answer {
  Tensor stress;
  double stiffness;  ///< largest diagonal entry of DDSDDE for normal components [Pa]
};

Umat::Umat(const Soil& soil)
    : elasticity_(Elasticity::of(soil)),
      properties_(soil.properties),
      library_(soil.library),
      own_(static_cast<std::size_t>(soil.state_variables)) {
  const auto [function, why] = find_function(library_);
  if (function == nullptr) throw CaseError("soil.library: " + why);
  function_ = function;
}

std::vector<StateVariable> Umat::state_variables() const {
  std::vector<StateVariable> variables;
  for (std::size_t k = 1; k <= own_; ++k)
    variables.push_back({fmt::format("state_{}", k), "1", fmt::format("STATEV({}) of the user's own model", k)});
  return variables;
}

Umat::Answer Umat::ask(const Tensor& stress, const Tensor& strain, std::span<double> state) const {
  std::array<double, 6> s, total, increment;
  double* const remembered = state.data() + own_;
  for (std::size_t c = 0; c < 6; ++c) {
    const double engineering = c < 3 ? 1.0 : 2.0;
    s[c] = stress[place[c]];
    increment[c] = engineering * strain[place[c]];
    total[c] = remembered[c];
  }
  std::array<double, 36> tangent{};
  std::array<double, 6> by_temperature{}, heat_by_strain{};
  double sse = 0.0, spd = 0.0, scd = 0.0, rpl = 0.0, drpldt = 0.0, pnewdt = 1.0;
  const std::array<double, 2> time{0.0, 0.0};
  constexpr double dtime = 1.0, temperature = 0.0, none = 0.0, length = 1.0;
  const std::array<double, 3> coords{};
  const std::array<double, 9> identity{1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  constexpr int ndi = 3, nshr = 3, ntens = 6, one = 1;
  const int nstatv = static_cast<int>(own_), nprops = static_cast<int>(properties_.size());
  std::array<char, 80> name;
  name.fill(' ');
  std::copy_n("SOIL", 4, name.begin());
  reinterpret_cast<Function>(function_)(
      s.data(), state.data(), tangent.data(), &sse, &spd, &scd, &rpl, by_temperature.data(), heat_by_strain.data(),
      &drpldt, total.data(), increment.data(), time.data(), &dtime, &temperature, &none, &none, &none, name.data(),
      &ndi, &nshr, &ntens, &nstatv, properties_.data(), &nprops, coords.data(), identity.data(), &pnewdt, &length,
      identity.data(), identity.data(), &one, &one, &one, &one, &one, &one, name.size());
  Answer answer;
  for (std::size_t c = 0; c < 6; ++c) {
    answer.stress[place[c]] = s[c];
    remembered[c] += increment[c];
  }
  answer.stiffness = std::max({tangent[0], tangent[7], tangent[14]});
  return answer;
}

double Umat::advance(Tensor& stress, const Tensor& strain, const Condition& /*condition*/,
                     std::span<double> state) const {
  const std::vector<double> before(state.begin(), state.begin() + static_cast<std::ptrdiff_t>(own_));
  const Tensor from = stress;
  stress = ask(stress, strain, state).stress;
  const auto mine = state.first(own_);
  if (!stress.allFinite() || !std::ranges::all_of(mine, [](double x) { return std::isfinite(x); }))
    throw MaterialFailure{fmt::format(
        "{}: the stress or state is not finite after the strain increment {:.6g} (xx yy zz xy yz xz, shear as tensors "
        "have it), from the stress {:.6g} Pa and the state {:.6g}",
        library_, fmt::join(strain, " "), fmt::join(from, " "), fmt::join(before, " "))};
  // The plastic strain is the part of the strain that is not elastic with the soil's moduli.
  Tensor elastic = Tensor::Zero();
  elasticity_.add_stress(strain.data(), elastic.data());
  const double plastic = root_j2(elastic - (stress - from)) / (elasticity_.shear * std::sqrt(3.0));
  const bool yields = plastic > 1e-9 * root_j2(elastic) / elasticity_.shear;
  return yields ? plastic : 0.0;
}

void Umat::judge(const Soil& soil, const Material::Complain& complain) {
  if (soil.library.empty()) complain("library", "expected the shared library with the user's own model, found none");
  const auto [function, why] = find_function(soil.library);
  if (function == nullptr) complain("library", why);
  const Umat model(soil);
  std::vector<double> state(model.state_size());
  const Answer answer = model.ask(Tensor::Zero(), Tensor::Zero(), state);
  if (!answer.stress.allFinite() || !std::ranges::all_of(state, [](double x) { return std::isfinite(x); }))
    complain("library",
             "its answer to no strain at all is not finite: are properties and state_variables as it expects?");
  const double most = model.elasticity_.constrained();
  if (answer.stiffness > (1.0 + 1e-6) * most)
    complain("youngs_modulus",
             fmt::format("with poissons_ratio the stiffness in one dimension is {:.4g} Pa, that of the "
                         "library {:.4g}: expected at least as much, for the substep is chosen by it",
                         most, answer.stiffness));
}

}  // namespace poretwin::solid
