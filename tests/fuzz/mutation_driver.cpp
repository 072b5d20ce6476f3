// SPDX-License-Identifier: Apache-2.0
// Runs a fuzz target over its seeds and thousands of damaged copies of them, the same ones every time. Compilers with
// libFuzzer link the target without this file and explore further.
//   <name>_fuzz SEED_FOLDER COUNT
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include <sys/resource.h>
#include <unistd.h>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

std::vector<std::string> read_seeds(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path());
  std::ranges::sort(files);
  std::vector<std::string> seeds;
  for (const auto& file : files) {
    std::ifstream stream(file, std::ios::binary);
    seeds.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
  }
  return seeds;
}

/// Damages a text or a binary file in the ways in which files get damaged, and in some in which only attackers do it.
class Mutator {
public:
  explicit Mutator(const std::vector<std::string>& seeds) : seeds_(seeds) {}

  std::string next() {
    std::string text = any(seeds_);
    for (std::size_t changes = 1 + below(4); changes > 0 && !text.empty(); --changes) change(text);
    return text;
  }

private:
  std::size_t below(std::size_t limit) { return limit == 0 ? 0 : random_() % limit; }
  const std::string& any(const std::vector<std::string>& list) { return list[below(list.size())]; }

  void change(std::string& text) {
    static const std::vector<std::string> odd = {
        "0", "-1", "1e308", "nan",   "-",    "99999999999", "2147483648", "1e-400", "\xff", "\"",  ",", "\n",
        "*", "+",  "",      "1.5.2", "0x10", "inf",         "$",          "\r\n",   "\t",   "1-1", "=", "  "};
    const std::size_t place = below(text.size());
    switch (below(8)) {
      case 0:
        text.resize(place);
        break;
      case 1:
        text[place] = static_cast<char>(random_());
        break;
      case 2:
        text[place] = static_cast<char>(text[place] ^ (1 << below(8)));
        break;
      case 3:
        text.erase(place, 1 + below(40));
        break;
      case 4:
        text.insert(place, text.substr(below(text.size()), below(80)));
        break;
      case 5:
        text.insert(place, any(odd));
        break;
      case 6: {
        const std::string& other = any(seeds_);
        text = text.substr(0, place) + other.substr(below(other.size() + 1));
        break;
      }
      default: {
        const auto begin = text.find_first_of("0123456789", place), end = text.find_first_not_of("0123456789", begin);
        if (begin != std::string::npos) text.replace(begin, end == std::string::npos ? end : end - begin, any(odd));
      }
    }
  }

  const std::vector<std::string>& seeds_;
  std::mt19937 random_{1};
};

/// An input that takes longer than this hangs: SIGALRM ends the program.
constexpr unsigned longest_time = 20;  // [s]

void run(const std::string& text) {
  alarm(longest_time);
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  alarm(0);
}

/// Most that the program held at a time.
std::size_t peak_bytes() {
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  return static_cast<std::size_t>(used.ru_maxrss) * 1024;
}

// No reader may take more than 200 MB and ten times the file. Sanitizers keep what was freed.
#if defined(__SANITIZE_ADDRESS__)
constexpr bool memory_counts = false;
#elif defined(__has_feature)
constexpr bool memory_counts = !__has_feature(address_sanitizer);
#else
constexpr bool memory_counts = true;
#endif

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "give a folder of seeds and a number of inputs\n"), 2;
  const auto seeds = read_seeds(argv[1]);
  if (seeds.empty()) return std::fprintf(stderr, "there are no seeds in %s\n", argv[1]), 2;
  std::size_t largest = 0;
  const auto run_one = [&](const std::string& text) {
    run(text);
    largest = std::max(largest, text.size());
  };
  for (const auto& seed : seeds) run_one(seed);
  Mutator mutator(seeds);
  for (int left = std::atoi(argv[2]); left > 0; --left) run_one(mutator.next());
  const std::size_t peak = peak_bytes(), most = 200'000'000 + 10 * largest;
  if (memory_counts && peak > most)
    return std::fprintf(stderr, "%zu bytes were held, at most %zu are allowed\n", peak, most), 1;
}
