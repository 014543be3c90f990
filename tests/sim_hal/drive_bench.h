// A head drive on a bus, and a hand-held master that speaks bytes to it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "sim_hal/head_drive.h"
#include "sim_hal/sim_bus.h"

namespace headway::sim {

class DriveBench {
 public:
  explicit DriveBench(const HeadDriveConfig& config = {}) : drive(config, drive_end_, Time{}) {
    drive_end_.listen(drive);
  }

  /// Lets time pass in ticks of 5 ms; with heartbeats of the master every 100 ms while `beating`.
  void run(double duration) {
    const Time end = now + seconds(duration);
    while (now < end) {
      if (beating && now >= next_beat_) {
        send(0x701, {5});
        next_beat_ = now + seconds(0.1);
      }
      now += seconds(0.005);
      can.advance(now);
      drive.tick(now);
      collect();
    }
  }
  void send(std::uint32_t id, const std::vector<std::uint8_t>& data) {
    hal::CanFrame f{.id = id, .dlc = static_cast<std::uint8_t>(data.size())};
    std::copy(data.begin(), data.end(), f.data.begin());
    master_end_.send(f);
  }
  std::vector<hal::CanFrame> heard(std::uint32_t id) const {
    std::vector<hal::CanFrame> out;
    for (const auto& f : frames)
      if (f.id == id) out.push_back(f);
    return out;
  }

  /// Expedited download; the abort code, 0 when accepted.
  std::uint32_t write(std::uint16_t index, std::uint8_t sub, int bytes, std::int64_t value) {
    return sdo({static_cast<std::uint8_t>(0x23 | (4 - bytes) << 2), byte(index, 0), byte(index, 1), sub,
                byte(value, 0), byte(value, 1), byte(value, 2), byte(value, 3)})
        .abort;
  }
  struct Answer {
    std::uint8_t command = 0;
    std::uint32_t abort = 0, value = 0;
    int bytes = 0;
  };
  Answer read(std::uint16_t index, std::uint8_t sub = 0) {
    return sdo({0x40, byte(index, 0), byte(index, 1), sub, 0, 0, 0, 0});
  }
  Answer sdo(const std::vector<std::uint8_t>& request) {
    frames.clear();
    send(0x611, request);
    run(0.005);
    const auto answers = heard(0x591);
    if (answers.size() != 1) return {.abort = 0xffffffff};
    const auto& d = answers[0].data;
    const std::uint32_t value = d[4] | d[5] << 8 | d[6] << 16 | static_cast<std::uint32_t>(d[7]) << 24;
    if (d[0] == 0x80) return {.command = d[0], .abort = value};
    return {.command = d[0], .value = value, .bytes = (d[0] & 0xe0) == 0x40 ? 4 - (d[0] >> 2 & 3) : 0};
  }

  /// Remaps one PDO as CiA 301 prescribes.
  void map(std::uint16_t communication, std::uint16_t mapping, std::uint32_t id, std::uint8_t type,
           const std::vector<std::uint32_t>& objects) {
    write(communication, 1, 4, 0x80000000 | id);
    write(communication, 2, 1, type);
    write(mapping, 0, 1, 0);
    for (std::size_t i = 0; i < objects.size(); ++i)
      write(mapping, static_cast<std::uint8_t>(i + 1), 4, objects[i]);
    write(mapping, 0, 1, static_cast<std::int64_t>(objects.size()));
    write(communication, 1, 4, id);
  }
  /// Boots, sets up as docs/bus.md asks for, and starts the node.
  void set_up() {
    run(0.1);
    write(0x1017, 0, 2, 100);
    write(0x1016, 1, 4, 0x0001012C);
    write(0x6007, 0, 2, 3);
    write(0x605A, 0, 2, 6);
    write(0x605E, 0, 2, 2);
    write(0x607D, 1, 4, -45000);
    write(0x607D, 2, 4, 45000);
    write(0x6081, 0, 4, 57000);
    write(0x6083, 0, 4, 230000);
    write(0x6084, 0, 4, 230000);
    write(0x6085, 0, 4, 400000);
    map(0x1400, 0x1600, 0x211, 255, {0x60400010, 0x60600008, 0x607A0020});
    map(0x1800, 0x1A00, 0x191, 1, {0x60410010, 0x60610008});
    map(0x1801, 0x1A01, 0x291, 1, {0x60640020, 0x606C0020});
    beating = true;
    send(0x000, {1, 0x11});
    run(0.01);
  }
  void enable() {
    for (const int word : {0x06, 0x07, 0x0F}) order(static_cast<std::uint16_t>(word), 0);
  }
  /// RPDO1.
  void order(std::uint16_t control_word, std::int32_t target) {
    send(0x211, {byte(control_word, 0), byte(control_word, 1), mode, byte(target, 0), byte(target, 1),
                 byte(target, 2), byte(target, 3)});
    run(0.005);
  }
  void go_to(std::int32_t target) {
    order(0x2F, target);
    order(0x3F, target);
    order(0x2F, target);
  }
  double angle() const { return drive.angle() * 180e3 / 3.14159265358979; }

  SimBus can;

 private:
  static std::uint8_t byte(std::int64_t value, int which) {
    return static_cast<std::uint8_t>(value >> (8 * which));
  }
  void collect() {
    std::array<hal::CanFrame, 16> some;
    while (const std::size_t n = master_end_.receive(some))
      frames.insert(frames.end(), some.begin(), some.begin() + static_cast<long>(n));
  }
  SimBus::Endpoint &drive_end_ = can.attach("drive"), &master_end_ = can.attach("master");
  Time next_beat_{};

 public:
  HeadDrive drive;
  Time now{};
  bool beating = false;
  std::uint8_t mode = 1;              ///< of operation, in each order
  std::vector<hal::CanFrame> frames;  ///< heard by the master since it was last cleared
};

}  // namespace headway::sim
