// SPDX-License-Identifier: Apache-2.0
#include "kalfem/distributed/ranks.hpp"

#include <algorithm>
#include <cstdlib>
#include <map>

#include "kalfem/base/invalid_input.hpp"
#include "kalfem/distributed/distributed_vectors.hpp"
#include "kalfem/distributed/mumps_instance.hpp"
#include "kalfem/distributed/mumps_workspace.hpp"
#include "kalfem/distributed/service.hpp"
#include "kalfem/linalg/makers.hpp"

namespace kalfem::distributed {

Ranks::Ranks(int& argc, char**& argv) {
  int threads = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &threads);
  if (threads < MPI_THREAD_SERIALIZED)
    throw InvalidInput("the MPI library has no support for threads", "those of a program take turns in calling it",
                       "use an MPI library with MPI_THREAD_SERIALIZED");
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &size_);
  service_ = std::make_unique<Service>(MPI_COMM_WORLD);
}

void Ranks::distribute(const RanksOptions& options) {
  const auto least_rows = std::max<Eigen::Index>(options.least_rows, size_);
  use_makers({
      .factor = [&service = *service_, least_rows, &needed = were_needed_](
                    const UpperTriangle& pattern, const EliminationOrder& order) -> std::unique_ptr<FactorWorkspace> {
        if (pattern.size < least_rows) return nullptr;
        needed = true;
        return std::make_unique<MumpsWorkspace>(service, pattern, order);
      },
      .long_vectors = [&service = *service_, least_rows](Eigen::Index rows) -> std::unique_ptr<LongVectors> {
        if (rows < least_rows) return nullptr;
        return std::make_unique<DistributedVectors>(service, rows);
      },
  });
}

Ranks::~Ranks() {
  if (!works_for_rank_0() && orders_) {
    use_makers({});
    service_->together({Task::finish}, [] {});
  }
  MPI_Finalize();
}

void Ranks::serve() {
  std::map<int, MumpsInstance> factors;
  std::map<int, VectorsPart> vectors;
  for (;;) {
    const Order order = service_->await();
    switch (order.task) {
      case Task::make_factor:
        factors.try_emplace(order.object, service_->ranks());
        break;
      case Task::run_factor:
        factors.at(order.object).run(static_cast<MumpsJob>(order.arguments[0]));
        break;
      case Task::free_factor:
        factors.erase(order.object);
        break;
      case Task::make_vectors:
        vectors.try_emplace(order.object, service_->ranks(), order.arguments[0]);
        break;
      case Task::use_vectors:
        vectors.at(order.object).follow(order);
        break;
      case Task::free_vectors:
        vectors.erase(order.object);
        break;
      case Task::finish:
        return;
    }
  }
}

void Ranks::abandon(int code) const {
  MPI_Abort(MPI_COMM_WORLD, code);
  std::abort();
}

}  // namespace kalfem::distributed
