// MPI's own handle of a communicator, for the few files of this folder that pass it to MPI or to Zoltan.
#pragma once

#define OMPI_SKIP_MPICXX 1
#include "common/tiles/communicator.hpp"

#include <mpi.h>

#include <atomic>

namespace poretwin::tiles {

struct Communicator::Mpi {
  MPI_Comm handle = MPI_COMM_NULL;
  int rank = 0, size = 1;
  std::uint64_t calls = 0;  ///< calls of this communicator so far, the same number on every rank
  Traffic traffic;
  std::atomic<std::uint64_t> step{0};
};

}  // namespace poretwin::tiles
