// SPDX-License-Identifier: Apache-2.0
#include "kalfem/distributed/service.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

namespace kalfem::distributed {
namespace {

constexpr int length = sizeof(Order) / sizeof(int);
constexpr auto shortest_sleep = std::chrono::microseconds(5), longest_sleep = std::chrono::microseconds(1000);

}  // namespace

void Service::announce(Order order) const {
  MPI_Request request;
  MPI_Ibcast(&order, length, MPI_INT, 0, ranks_, &request);
  MPI_Wait(&request, MPI_STATUS_IGNORE);
}

Order Service::await() const {
  Order order;
  MPI_Request request;
  MPI_Ibcast(&order, length, MPI_INT, 0, ranks_, &request);
  auto sleep = shortest_sleep;
  for (int arrived = 0;;) {
    MPI_Test(&request, &arrived, MPI_STATUS_IGNORE);
    if (arrived != 0) return order;
    std::this_thread::sleep_for(sleep);
    sleep = std::min(longest_sleep, sleep + sleep / 4 + std::chrono::microseconds(1));
  }
}

}  // namespace kalfem::distributed
