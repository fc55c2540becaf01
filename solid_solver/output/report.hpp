// The output of a run about the soil: fields of its particles, counters, warnings.
#pragma once

#include "common/coupling/phase.hpp"
#include "solid_solver/statics/rest.hpp"

namespace poretwin::solid {

/// Fields of the free particles for output. The frame refers to the state and is valid until the state changes.
template <int D>
OutputFrame frame_of(const Setup<D>& setup, const State<D>& state);

/// The field `failing_strain` of a frame. strain: of the free particles, as in FactorOfSafety; it must outlive the
/// frame, and is zero where it is empty. factor: by which the strength is divided, in words.
OutputField failing_strain_field(const ScalarArray& strain, const std::string& factor);

template <int D>
std::map<std::string, double> counters_of(const State<D>& state, const RestReport& rest);

template <int D>
std::vector<Warning> warnings_of(const Setup<D>& setup, const State<D>& state, const RestReport& rest);

}  // namespace poretwin::solid
