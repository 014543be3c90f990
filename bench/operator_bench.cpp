// What the operator's page costs the bus loop: nothing, whatever its clients do.
//
// served: the bus loop as the program runs it, alone and then with a server that shows 2 MB thirty times a
// second to eight clients, one of which reads nothing. Missed cycles of both, what the clients got, and how
// the memory grew.
// `--seconds N` is the length of a run (20).
#include <array>
#include <atomic>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <fmt/format.h>
#include <unistd.h>

#include "bench/arguments.h"
#include "bench/figures.h"
#include "bench/runtime_live_bus.h"
#include "hal/error.h"
#include "operator/server.h"
#include "runtime/real_time.h"
#include "tests/source_dir/source_dir.h"

namespace headway::bench {
namespace {

constexpr std::size_t kMessage = 2'000'000;  // [bytes]
constexpr int kHealthy = 7;
int length = 20;  // [s]

runtime::RealTime urgent() {
  const auto last = static_cast<int>(::sysconf(_SC_NPROCESSORS_ONLN)) - 1;
  return {.want = runtime::RealTime::Want::kEnforce, .bus_processor = last};
}

/// A picture of 2 MB at each second look, about thirty times a second; of the others one each.
class Flood final : public remote::Source {
 public:
  Flood() {
    for (remote::Newest& newest : newest_) newest = message(1000);
  }
  void look(const remote::Wanted&) override {
    if (++looks_ % 2 != 0) return;
    remote::Newest& picture = newest_[static_cast<std::size_t>(remote::Channel::kPicture)];
    const std::uint64_t number = picture.number;
    picture = message(kMessage);
    picture.number = number + 1;
  }
  remote::Newest newest(remote::Channel channel) const override {
    return newest_[static_cast<std::size_t>(channel)];
  }
  std::uint32_t status_number() const override { return looks_; }
  std::shared_ptr<const std::vector<std::byte>> voxels(std::uint64_t& version) override {
    return std::exchange(version, 1) == 0 ? message(1000).cdr : nullptr;
  }
  std::shared_ptr<const std::string> file(const std::string&) override { return nullptr; }
  std::string metrics() override { return {}; }

 private:
  static remote::Newest message(std::size_t size) {
    return {std::make_shared<const std::vector<std::byte>>(size), 1, Time{}};
  }
  std::array<remote::Newest, remote::kChannels.size()> newest_;
  std::uint32_t looks_ = 0;
};

/// Subscribes to everything, and reads or does not.
class Client {
 public:
  Client(std::uint16_t port, bool reads) : socket_(io_) {
    namespace beast = boost::beast;
    beast::get_lowest_layer(socket_).connect({boost::asio::ip::make_address("127.0.0.1"), port});
    socket_.set_option(beast::websocket::stream_base::decorator([](beast::websocket::request_type& request) {
      request.set(beast::http::field::sec_websocket_protocol, "foxglove.websocket.v1");
    }));
    socket_.handshake(fmt::format("127.0.0.1:{}", port), "/ws");
    std::string all;
    for (std::size_t i = 0; i < remote::kChannels.size(); ++i)
      all += fmt::format("{}{{\"id\":{},\"channelId\":{}}}", i ? "," : "", i, i);
    socket_.text(true);
    socket_.write(boost::asio::buffer("{\"op\":\"subscribe\",\"subscriptions\":[" + all + "]}"));
    if (reads) thread_ = std::thread([this] { read(); });
  }
  ~Client() {
    boost::beast::get_lowest_layer(socket_).socket().shutdown(boost::asio::ip::tcp::socket::shutdown_both,
                                                              ignored_);
    if (thread_.joinable()) thread_.join();
  }
  std::size_t latched() const { return latched_; }
  std::uint64_t pictures() const { return pictures_; }

 private:
  void read() {
    std::set<std::uint32_t> latched;
    boost::beast::flat_buffer buffer;
    boost::beast::error_code fault;
    while (socket_.read(buffer, fault), !fault) {
      const auto data = buffer.cdata();
      std::uint32_t id = 0;
      const auto* bytes = static_cast<const std::byte*>(data.data());
      if (data.size() > 13 && bytes[0] == std::byte{1}) {
        std::memcpy(&id, bytes + 1, sizeof id);
        if (remote::kChannels[id].latched) latched.insert(id);
        if (id == static_cast<std::uint32_t>(remote::Channel::kPicture)) ++pictures_;
      }
      latched_ = latched.size();
      buffer.consume(buffer.size());
    }
  }
  boost::asio::io_context io_;
  boost::beast::websocket::stream<boost::beast::tcp_stream> socket_;
  boost::system::error_code ignored_;
  std::atomic<std::size_t> latched_{0};
  std::atomic<std::uint64_t> pictures_{0};
  std::thread thread_;
};

double resident_mib() {
  std::size_t size = 0, pages = 0;
  std::ifstream("/proc/self/statm") >> size >> pages;
  return static_cast<double>(pages) * static_cast<double>(::sysconf(_SC_PAGESIZE)) / (1 << 20);
}

/// A run of the bus loop; `while_it_runs` is called after a quarter of it and at its end.
template <class Look>
LiveBus::Result run(const Look& look) {
  LiveBus bus(app::read_robot(source_dir() / "config/hrp2/robot.yaml"), urgent());
  hal::MonotonicClock clock;
  for (const double part : {0.25, 0.75}) {
    clock.sleep_until(clock.now() + seconds(part * length));
    look();
  }
  return bus.stop();
}

void show(const char* what, const LiveBus::Result& result) {
  std::printf("%-8s wake-up p99 %.1f  p99.9 %.1f  max %.1f us, %llu of %llu missed, %llu heap calls\n", what,
              1e6 * to_seconds(result.times.bus_wake_up.p99), 1e6 * to_seconds(result.times.bus_wake_up.p999),
              1e6 * to_seconds(result.times.bus_wake_up.max),
              static_cast<unsigned long long>(result.times.missed),
              static_cast<unsigned long long>(result.times.bus_wake_up.count),
              static_cast<unsigned long long>(result.heap_calls));
}

void served(benchmark::State& state) {
  for (auto _ : state) {
    const LiveBus::Result alone = run([] {});
    show("alone", alone);
    Flood flood;
    hal::MonotonicClock clock;
    remote::ServerConfig config;
    config.port = 0;
    remote::Server server(config, flood, clock);
    std::vector<std::unique_ptr<Client>> clients;
    for (int i = 0; i <= kHealthy; ++i)
      clients.push_back(std::make_unique<Client>(server.port(), i < kHealthy));
    std::vector<double> resident;
    const LiveBus::Result beside = run([&] { resident.push_back(resident_mib()); });
    show("served", beside);
    std::size_t least = remote::kChannels.size();
    std::uint64_t pictures = 0;
    for (int i = 0; i < kHealthy; ++i) {
      least = std::min(least, clients[static_cast<std::size_t>(i)]->latched());
      pictures += clients[static_cast<std::size_t>(i)]->pictures();
    }
    figure("alone_missed", static_cast<double>(alone.times.missed));
    figure("served_missed", static_cast<double>(beside.times.missed));
    figure("served_heap_calls", static_cast<double>(beside.heap_calls));
    figure("latched_channels", 8);
    figure("latched_least_received", static_cast<double>(least));
    figure("pictures_per_client_hz", static_cast<double>(pictures) / kHealthy / length);
    figure("resident_growth_mib", resident.back() - resident.front());
    clients.clear();
  }
}
BENCHMARK(served)->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace
}  // namespace headway::bench

int main(int argc, char** argv) {
  using namespace headway;
  try {
    bench::length = bench::take(argc, argv, "--seconds", bench::length);
    runtime::lock_memory(bench::urgent());
    return bench::run(argc, argv);
  } catch (const Error& fault) {
    std::fprintf(stderr, "%s: %s\n", argv[0], fault.what());
    return 1;
  }
}
