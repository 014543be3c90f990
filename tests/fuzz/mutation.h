// Whole inputs of a fuzzer, broken at random: what ordinary tests do in its place.
#pragma once

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace headway::fuzz {

class Mutation {
 public:
  explicit Mutation(std::uint64_t seed) : random_(seed) {}

  std::string of(std::string bytes, const std::vector<std::string>& others) {
    for (int times = 1 + static_cast<int>(below(4)); times > 0; --times) {
      const std::size_t at = 1 + below(bytes.size());  // the first byte chooses the reader
      switch (below(6)) {
        case 0:
          bytes.resize(at);
          break;
        case 1:
          bytes.insert(std::min(at, bytes.size()), bytes.substr(std::min(at, bytes.size()), below(64)));
          break;
        case 2:
          bytes.erase(std::min(at, bytes.size()), below(64));
          break;
        case 3:
          bytes = bytes.substr(0, at) + others[below(others.size())].substr(1);
          break;
        case 4:
          put_number(bytes);
          break;
        default:
          bytes[std::min(at, bytes.size() - 1)] = static_cast<char>(random_() & 255);
      }
    }
    return bytes;
  }

 private:
  std::size_t below(std::size_t end) { return end == 0 ? 0 : random_() % end; }

  /// Another number in place of one that stands in text.
  void put_number(std::string& bytes) {
    static const std::vector<std::string> numbers{"0",          "-1",
                                                  "1e300",      "nan",
                                                  "inf",        "99999999999999999999",
                                                  "0.5",        "4096",
                                                  "2147483648", "18446744073709551615"};
    const std::size_t at = bytes.find_first_of("0123456789", 1 + below(200));
    if (at == std::string::npos) return;
    const std::size_t end = std::min(bytes.find_first_not_of("0123456789.", at), bytes.size());
    bytes.replace(at, end - at, numbers[below(numbers.size())]);
  }

  std::mt19937_64 random_;
};

}  // namespace headway::fuzz
