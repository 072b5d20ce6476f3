// SPDX-License-Identifier: Apache-2.0
#include "kalfem/distributed/mumps_on_all_ranks.hpp"

namespace kalfem::distributed {

MumpsOnAllRanks::MumpsOnAllRanks(Service& service) : service_(service), number_(service.new_object()) {
  service_.together({Task::make_factor, number_}, [&] { own_.emplace(service_.ranks()); });
}

MumpsOnAllRanks::~MumpsOnAllRanks() {
  service_.together({Task::free_factor, number_}, [&] { own_.reset(); });
}

int MumpsOnAllRanks::run(MumpsJob job) {
  service_.together({Task::run_factor, number_, {static_cast<int>(job)}}, [&] { own_->run(job); });
  return own_->state().infog[0];
}

}  // namespace kalfem::distributed
