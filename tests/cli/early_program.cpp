// SPDX-License-Identifier: Apache-2.0
// A program that says what it has reached: initialisation before main, and main.
#include <cstdio>

namespace {

struct Early {
  Early() { std::puts("initialised"); }
};
const Early early;

}  // namespace

int main() { std::puts("main"); }
