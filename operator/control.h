// Who has control, as clients ask for it, and what the main loop is told of that. In the server's thread but
// for what says otherwise.
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "hal/clock.h"
#include "hal/exchange.h"
#include "operator/lease.h"

namespace headway::remote {

/// An answer that says why not; text of any kind is taken.
std::string refusal(const std::string& why);

/// As the client numbered so calls itself, at most 40 bytes of it.
std::string name_in(const nlohmann::json& body, std::uint64_t client);

class Control {
 public:
  /// What the main loop has to know.
  struct Word {
    std::uint32_t number = 0;    ///< of the lease; 0: nobody's
    std::uint32_t released = 0;  ///< times that control was given up, or ran out
    Time at{};                   ///< when the holder was heard
  };

  explicit Control(const hal::Clock& clock) : clock_(clock) {}

  /// Often: who renews says which of the newest statuses he saw last. Control runs out here as well.
  void look(std::uint32_t status_number);

  bool holds(std::uint64_t client) const { return lease_.holds(client); }
  /// Why a client that does not have control is not obeyed.
  std::string refuse() const;
  /// Answers to calls. `name`: as the client calls itself.
  std::string take(std::uint64_t client, const std::string& name);
  std::string renew(std::uint64_t client, const nlohmann::json& body);
  std::string release(std::uint64_t client);

  /// In the main loop's thread: null where nothing is new.
  const Word* news() { return word_.update() ? &word_.value() : nullptr; }
  Lease::Holder holder() {
    holder_.update();
    return holder_.value();
  }

 private:
  void expire();
  void tell();

  const hal::Clock& clock_;
  Lease lease_;
  std::uint32_t released_ = 0;
  std::deque<std::pair<std::uint32_t, Time>> statuses_;  ///< numbers of the newest, and since when they are
  hal::NewestSlot<Word> word_;
  hal::NewestSlot<Lease::Holder> holder_;
};

}  // namespace headway::remote
