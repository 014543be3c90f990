// The server under clients that mean it no good, and those that only do it badly. docs/security.md names
// these tests.
#include "operator/server.h"

#include <cstring>
#include <fstream>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/operator/server_bench.h"

namespace headway::remote {
namespace {

TEST_F(ServerTest, ServesThePageAndItsFiles) {
  begin();
  const Response page = request(*server_, http::verb::get, "/", {{"Accept-Encoding", "gzip"}});
  EXPECT_EQ(page.result_int(), 200U);
  EXPECT_EQ(page[http::field::content_encoding], "gzip");
  EXPECT_THAT(std::string(page["Content-Security-Policy"]), HasSubstr("default-src 'none'"));
  EXPECT_EQ(page["X-Content-Type-Options"], "nosniff");
  EXPECT_EQ(code(*server_, http::verb::get, "/", {{"If-None-Match", "\"1\""}}), 304);
  EXPECT_EQ(request(*server_, http::verb::get, "/healthz").body(), "ok\n");
  EXPECT_THAT(request(*server_, http::verb::get, "/metrics").body(), testing::StartsWith("headway_up 1\n"));
  EXPECT_EQ(request(*server_, http::verb::get, "/map.pgm").body(), "P5");
  EXPECT_EQ(code(*server_, http::verb::get, "/map.bt"), 404);
  EXPECT_EQ(code(*server_, http::verb::post, "/"), 405);
}

TEST_F(ServerTest, PathsLeadNowhereElse) {
  begin();
  for (const char* path : {"/../etc/passwd", "/%2e%2e/etc/passwd", "//etc/passwd", "/page/../../tokens",
                           "/map.pgm/..", "/index.html%00.js", "/\\..\\x"})
    EXPECT_EQ(code(*server_, http::verb::get, path), 404) << path;
}

TEST_F(ServerTest, OtherNamesAndOriginsAreTurnedAway) {
  begin();
  EXPECT_EQ(code(*server_, http::verb::get, "/", {{"Host", "evil.example"}}), 421);
  EXPECT_EQ(code(*server_, http::verb::get, "/", {{"Host", "127.0.0.1.evil.example"}}), 421);
  EXPECT_EQ(code(*server_, http::verb::get, "/", {{"Origin", "http://evil.example"}}), 403);
  EXPECT_EQ(code(*server_, http::verb::get, "/", {{"Origin", "null"}}), 403);
  EXPECT_EQ(
      code(*server_, http::verb::get, "/", {{"Origin", fmt::format("http://127.0.0.1:{}", server_->port())}}),
      200);
  Talker foreign(*server_, {{"Origin", "http://evil.example"}});
  EXPECT_TRUE(foreign.refused) << "a page of another server must not steer the robot";
  EXPECT_EQ(upgrade(*server_, {{"Origin", "http://evil.example"}}), 403);
}

TEST_F(ServerTest, WithoutATokenNothingIsShownWhereOneIsNeeded) {
  begin_with_token();
  EXPECT_EQ(code(*server_, http::verb::get, "/map.pgm"), 401);
  EXPECT_EQ(code(*server_, http::verb::get, "/metrics"), 401);
  for (const char* path : {"xmap.pgm", "xmap.yaml", "?x", "/x", "//map.pgm", "/map.pgm?x"})
    EXPECT_EQ(code(*server_, http::verb::get, path), 401) << path;
  EXPECT_EQ(code(*server_, http::verb::get, "/healthz"), 200);
  EXPECT_EQ(Json::parse(request(*server_, http::verb::get, "/session").body()).at("role"), "none");
  Talker stranger(*server_);
  EXPECT_TRUE(stranger.refused);
  EXPECT_EQ(upgrade(*server_), 401);
  Talker forged(*server_, {{"Cookie", "headway_session=" + std::string(64, 'a')}});
  EXPECT_TRUE(forged.refused);
}

TEST_F(ServerTest, ATokenIsTradedForACookieThatScriptsCannotRead) {
  begin_with_token();
  const Fields json{{"Content-Type", "application/json"}};
  const Response in =
      request(*server_, http::verb::post, "/login", json, Json{{"token", tokens_.operate}}.dump());
  ASSERT_EQ(in.result_int(), 204U);
  const std::string cookie(in[http::field::set_cookie]);
  EXPECT_THAT(cookie, HasSubstr("HttpOnly"));
  EXPECT_THAT(cookie, HasSubstr("SameSite=Strict"));
  const std::string session = cookie.substr(0, cookie.find(';'));
  EXPECT_THAT(session, testing::Not(HasSubstr(tokens_.operate)));
  Talker known(*server_, {{"Cookie", "a=b; " + session}});
  EXPECT_FALSE(known.refused);
  server_.reset();
  begin_with_token();
  Talker replayed(*server_, {{"Cookie", session}});
  EXPECT_TRUE(replayed.refused) << "a cookie of an earlier run counts no more";
}

TEST_F(ServerTest, TokensCannotBeGuessedQuickly) {
  begin_with_token();
  const Fields json{{"Content-Type", "application/json"}};
  int wrong = 0, refused = 0;
  for (int i = 0; i < 12; ++i) {
    const int answer =
        code(*server_, http::verb::post, "/login", json, Json{{"token", random_token()}}.dump());
    wrong += answer == 401;
    refused += answer == 429;
  }
  EXPECT_EQ(wrong, Access::kMostFailures);
  EXPECT_EQ(refused, 12 - Access::kMostFailures);
  EXPECT_EQ(code(*server_, http::verb::post, "/login", json, Json{{"token", tokens_.operate}}.dump()), 204)
      << "who tries wrong ones locks nobody out";
}

TEST_F(ServerTest, FormsOfOtherPagesCannotLogIn) {
  begin_with_token();
  const std::string body = Json{{"token", tokens_.operate}}.dump();
  EXPECT_EQ(code(*server_, http::verb::post, "/login", {{"Content-Type", "text/plain"}}, body), 415);
  EXPECT_EQ(code(*server_, http::verb::post, "/login",
                 {{"Content-Type", "application/json"}, {"Origin", "http://evil.example"}}, body),
            403);
  EXPECT_EQ(code(*server_, http::verb::get, "/login"), 405);
  EXPECT_EQ(code(*server_, http::verb::post, "/login", {{"Content-Type", "application/json"}}, "[1"), 400);
}

TEST_F(ServerTest, TokensThatOthersMayReadAreRefused) {
  const std::filesystem::path file = folder_ / "tokens";
  tokens_in(file);
  using std::filesystem::perms;
  EXPECT_EQ(std::filesystem::status(file).permissions(), perms::owner_read | perms::owner_write);
  std::filesystem::permissions(file, perms::owner_read | perms::group_read);
  EXPECT_THROW(tokens_in(file), InputError);
  std::ofstream(folder_ / "bad") << "operator 12\n";
  std::filesystem::permissions(folder_ / "bad", perms::owner_read);
  EXPECT_THROW(tokens_in(folder_ / "bad"), InputError);
}

TEST_F(ServerTest, AViewerLooksOnAndMayStop) {
  begin_with_token();
  const Response in = request(*server_, http::verb::post, "/login", {{"Content-Type", "application/json"}},
                              Json{{"token", tokens_.view}}.dump());
  const std::string cookie(in[http::field::set_cookie]);
  Talker viewer(*server_, {{"Cookie", cookie.substr(0, cookie.find(';'))}});
  viewer.call("take_control");
  EXPECT_THAT(viewer.answered().dump(), HasSubstr("viewer"));
  viewer.call("plan_preview", R"({"x":0,"y":0})");
  EXPECT_THAT(viewer.answered().dump(), HasSubstr("viewer"));
  viewer.call("stop");
  ASSERT_TRUE(until([&] { return serve(), was_asked("stop"); }));
  EXPECT_EQ(viewer.answered().at("ok"), true);
  EXPECT_FALSE(was_asked("plan_preview"));
}

TEST_F(ServerTest, OnlyWhoHasControlIsObeyed) {
  begin();
  Talker one(*server_), other(*server_);
  one.call("plan_confirm", R"({"plan":1})");
  EXPECT_THAT(one.answered().dump(), HasSubstr("take control first"));
  one.call("take_control", R"({"name":"Ada"})");
  EXPECT_EQ(one.answered().at("lease"), 1);
  other.call("take_control", R"({"name":"Bob"})");
  EXPECT_THAT(other.answered().dump(), HasSubstr("Ada has control"));
  other.call("plan_preview", R"({"x":0,"y":0})");
  EXPECT_THAT(other.answered().dump(), HasSubstr("Ada has control"));
  other.call("renew", R"({"lease":1,"state":4000000000})");
  EXPECT_THAT(other.answered().dump(), HasSubstr("do not have control"));
  one.call("plan_preview", R"({"x":0,"y":0})");
  ASSERT_TRUE(until([&] { return serve(), was_asked("plan_preview"); }));
  EXPECT_EQ(one.answered().at("ok"), true);
  one.call("release_control");
  EXPECT_EQ(one.answered().at("ok"), true);
  other.call("take_control", R"({"name":"Bob"})");
  EXPECT_EQ(other.answered().at("lease"), 2);
  EXPECT_EQ(server_->holder().name, "Bob");
}

TEST_F(ServerTest, WhoSeesNothingNewCannotRenew) {
  begin();
  Talker blind(*server_);
  blind.call("take_control");
  ASSERT_EQ(blind.answered().at("ok"), true);
  blind.call("renew", R"({"lease":1,"state":0})");
  EXPECT_THAT(blind.answered().dump(), HasSubstr("too old"));
  blind.call("renew", R"({"lease":1})");
  EXPECT_THAT(blind.answered().dump(), HasSubstr("expected lease and state"));
}

TEST_F(ServerTest, OnlyWhoTellsAStatusThatThereWasRenews) {
  begin();
  Talker one(*server_);
  one.call("take_control");
  ASSERT_EQ(one.answered().at("ok"), true);
  for (const char* state : {"4294967295", "4294967296", "18446744073709551615", "-1", "0.5"}) {
    one.call("renew", fmt::format(R"({{"lease":1,"state":{}}})", state));
    EXPECT_EQ(one.answered().at("ok"), false) << state;
  }
  one.call("renew", fmt::format(R"({{"lease":1,"state":{}}})", flow_.status_number()));
  EXPECT_EQ(one.answered().at("ok"), true);
  one.call("renew", fmt::format(R"({{"lease":0,"state":{}}})", flow_.status_number()));
  EXPECT_THAT(one.answered().dump(), HasSubstr("take control again"));
}

TEST(Lease, IsNotRenewedByTakingControlAgain) {
  Lease lease;
  EXPECT_EQ(lease.take(1, "Ada", at_seconds(10)), 1U);
  EXPECT_EQ(lease.take(1, "Ada", at_seconds(14)), 1U) << "who sees nothing may ask again and again";
  EXPECT_TRUE(lease.expire(at_seconds(15.1)));
  EXPECT_EQ(lease.take(1, "Ada", at_seconds(15.2)), 2U);
}

TEST_F(ServerTest, ANameOfAnyAlphabetIsCutBetweenItsCharactersAndAllAreStillHeard) {
  begin();
  Talker one(*server_), other(*server_);
  one.call("take_control", R"({"name":"Оператор Константинополь"})");
  ASSERT_EQ(one.answered().at("ok"), true);
  other.call("take_control");
  EXPECT_THAT(other.answered().dump(), HasSubstr("Оператор Константино"));
  other.call("stop");
  ASSERT_TRUE(until([&] { return serve(), was_asked("stop"); }));
}

TEST_F(ServerTest, AStopOvertakesAllElseAndTheLeaseWaitsForNothing) {
  begin();
  Talker one(*server_), other(*server_);
  one.call("take_control");
  ASSERT_EQ(one.answered().at("ok"), true);
  for (int i = 0; i < 8; ++i) one.call("plan_preview", R"({"x":0,"y":0})");
  for (int i = 0; i < 300; ++i) {
    one.call("renew", fmt::format(R"({{"lease":1,"state":{}}})", flow_.status_number()));
    one.answered();
  }
  other.call("stop");
  other.call("ping");
  EXPECT_EQ(other.answered().count("now_ns"), 1U) << "so the stop has been heard";
  serve();
  ASSERT_EQ(asked_.size(), 4U) << "and the main loop has its own work to do";
  EXPECT_EQ(asked_[0].service, "lease");
  EXPECT_EQ(asked_[1].service, "stop");
  EXPECT_EQ(asked_[2].service, "plan_preview");
}

TEST_F(ServerTest, WhoGivesControlUpIsToldOfThoughAnotherTakesItAtOnce) {
  begin();
  Talker one(*server_), other(*server_);
  one.call("take_control");
  ASSERT_EQ(one.answered().at("ok"), true);
  one.call("release_control");
  ASSERT_EQ(one.answered().at("ok"), true);
  other.call("take_control");
  ASSERT_EQ(other.answered().at("ok"), true);
  serve();
  ASSERT_EQ(asked_.size(), 1U);
  const Json word = Json::parse(asked_[0].body);
  EXPECT_EQ(word.at("lease"), 2);
  EXPECT_EQ(word.at("released"), 1);
}

TEST_F(ServerTest, IsKnownByItsMachinesName) {
  begin();
  EXPECT_EQ(code(*server_, http::verb::get, "/healthz", {{"Host", asio::ip::host_name() + ":8760"}}), 200);
}

TEST_F(ServerTest, BadRequestsAreAnsweredAndCostOnlyTheirSender) {
  begin();
  Talker bad(*server_), good(*server_);
  const auto told = [&](const std::string& text) {
    bad.say(text);
    return bad.told();
  };
  EXPECT_THAT(told("hello"), HasSubstr("JSON object"));
  EXPECT_THAT(told("{}"), HasSubstr("op: is missing"));
  EXPECT_THAT(told(R"({"op":"dance"})"), HasSubstr("not offered"));
  EXPECT_THAT(told(R"({"op":"subscribe"})"), HasSubstr("expected a list"));
  EXPECT_THAT(told(R"({"op":"subscribe","subscriptions":[{"id":1,"channelId":99}]})"),
              HasSubstr("no channel 99"));
  EXPECT_THAT(told(R"({"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}]})"),
              HasSubstr("whole number"));
  EXPECT_THAT(told(R"({"op":"unsubscribe","subscriptionIds":["x"]})"), HasSubstr("whole numbers"));
  EXPECT_THAT(told(std::string(1000, '[')), HasSubstr("not deeper than 16"));
  EXPECT_THAT(told(R"({"op":"advertise","channels":[]})"), HasSubstr("not acted upon"));
  bad.say_bytes("\x09");
  EXPECT_THAT(bad.told(), HasSubstr("unknown kind"));
  bad.say_bytes(std::string("\2\0\0", 3));
  EXPECT_THAT(bad.told(), HasSubstr("shorter than its head"));
  bad.say_bytes(Talker::call_bytes(999, 5, "{}"));
  EXPECT_THAT(bad.answered().dump(), HasSubstr("no such service"));
  bad.call("ping", std::string(1000, '{'));
  EXPECT_THAT(bad.answered().dump(), HasSubstr("not deeper"));
  good.call("ping");
  EXPECT_EQ(good.answered().at("ok"), true);
  for (int i = 0; i < 200 && !bad.ended; ++i) bad.say("x");
  EXPECT_TRUE(until([&] { return bad.hear().empty(); })) << "who goes on with it is hung up on";
  good.call("ping");
  EXPECT_EQ(good.answered().at("ok"), true);
}

TEST_F(ServerTest, MessagesWithoutEndAreCutOff) {
  begin();
  Talker large(*server_);
  large.say(std::string(2 << 20, 'x'));
  EXPECT_TRUE(until([&] { return large.hear().empty(); }));
  Talker good(*server_);
  good.call("ping");
  EXPECT_EQ(good.answered().at("ok"), true);
}

TEST_F(ServerTest, HeadsAndBodiesWithoutEndAreCutOff) {
  begin();
  Raw head(*server_);
  head.send("GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: " + std::string(20000, 'x'));
  EXPECT_THAT(head.receive(), HasSubstr("413"));
  EXPECT_EQ(code(*server_, http::verb::get, "/healthz"), 200);
}

TEST_F(ServerTest, WhoSendsItsRequestForEverIsHungUpOn) {
  begin();
  std::vector<std::unique_ptr<Raw>> slow;
  for (int i = 0; i < 20; ++i) {
    slow.push_back(std::make_unique<Raw>(*server_));
    slow.back()->send("GET / HT");
  }
  EXPECT_EQ(code(*server_, http::verb::get, "/healthz"), 200) << "others are served meanwhile";
  EXPECT_EQ(slow.front()->receive(), "") << "after five seconds";
}

TEST_F(ServerTest, OnlyItsOwnPathIsAWebSocketAndOnlyWithItsProtocol) {
  begin();
  EXPECT_EQ(upgrade(*server_, {}, "/page.js"), 404);
  EXPECT_EQ(upgrade(*server_, {}, "/ws", "chat"), 400);
  EXPECT_EQ(upgrade(*server_, {}, "/ws", ""), 400);
  Talker newer(*server_, {}, "/ws", "foxglove.sdk.v1");
  EXPECT_FALSE(newer.refused);
  EXPECT_EQ(code(*server_, http::verb::get, "/ws"), 426);
}

TEST_F(ServerTest, CompressionIsNotAgreedTo) {
  begin();
  Talker squeezed(*server_, {{"Sec-WebSocket-Extensions", "permessage-deflate; client_max_window_bits"}});
  ASSERT_FALSE(squeezed.refused);
  EXPECT_EQ(squeezed.answer[http::field::sec_websocket_extensions], "");
}

TEST_F(ServerTest, TheNinthViewerIsTurnedAwayUntilOneLeaves) {
  begin();
  std::vector<std::unique_ptr<Talker>> all;
  for (int i = 0; i < 8; ++i) {
    all.push_back(std::make_unique<Talker>(*server_));
    ASSERT_FALSE(all.back()->refused) << i;
  }
  EXPECT_EQ(upgrade(*server_), 503);
  all.pop_back();
  EXPECT_TRUE(until([&] { return !Talker(*server_).refused; }));
}

TEST_F(ServerTest, AFloodOfCallsIsHeldBackAndAStopGetsThrough) {
  begin();
  Talker flood(*server_), other(*server_);
  flood.call("take_control");
  ASSERT_EQ(flood.answered().at("ok"), true);
  for (int i = 0; i < 500; ++i) flood.call("plan_preview", R"({"x":0,"y":0})");
  int held_back = 0;
  for (int i = 0; i < 400; ++i) held_back += flood.answered().value("ok", true) == false;
  EXPECT_EQ(held_back, 400);
  other.call("stop");
  ASSERT_TRUE(until([&] { return serve(), was_asked("stop"); }));
  EXPECT_LE(std::ranges::count(asked_, "plan_preview", &Ask::service), 20);
}

TEST_F(ServerTest, WhereTheMainLoopHangsThatIsSaid) {
  begin();
  Talker waits(*server_);
  waits.call("stop");
  EXPECT_THAT(waits.answered().dump(), HasSubstr("busy"));
}

TEST_F(ServerTest, WhoReadsNothingCostsTheOthersNothing) {
  flow_.size_ = 2'000'000;
  begin();
  Talker frozen(*server_), healthy(*server_);
  const std::string everything = [] {
    Json list = Json::array();
    for (std::size_t i = 0; i < kChannels.size(); ++i) list.push_back({{"id", i}, {"channelId", i}});
    return Json{{"op", "subscribe"}, {"subscriptions", list}}.dump();
  }();
  frozen.say(everything);
  healthy.say(everything);
  std::set<std::uint32_t> latched;
  int pictures = 0;
  while (pictures < 60) {
    const std::string message = healthy.hear();
    ASSERT_FALSE(message.empty());
    std::uint32_t id = 0;
    std::memcpy(&id, message.data() + 1, sizeof id);
    if (id == static_cast<std::uint32_t>(Channel::kPicture))
      ++pictures;
    else
      latched.insert(id);
  }
  EXPECT_EQ(latched.size(), kChannels.size() - 2) << "all that are latched but the cloud's";
  EXPECT_LT(server_->figures().messages, 60U + 60U) << "the frozen one was not sent what it does not read";
}

TEST_F(ServerTest, WhatEachViewerMissedIsKnown) {
  flow_.size_ = 2'000'000;
  begin();
  Talker frozen(*server_), healthy(*server_);
  const auto picture = static_cast<std::size_t>(Channel::kPicture);
  const std::string subscribe =
      Json{{"op", "subscribe"}, {"subscriptions", {{{"id", picture}, {"channelId", picture}}}}}.dump();
  frozen.say(subscribe);
  healthy.call("take_control", R"({"name":"Ada"})");
  EXPECT_EQ(healthy.answered().at("ok"), true);
  ASSERT_TRUE(until([&] {
    const auto& viewers = server_->viewers();
    return viewers.size() == 2 && viewers[0].missed > 20 && viewers[1].has_control;
  }));
  const std::vector<ViewerStatus> viewers = server_->viewers();
  EXPECT_EQ(viewers[1].name, "Ada");
  EXPECT_EQ(viewers[1].missed, 0U);
  EXPECT_FALSE(viewers[0].has_control);
  for (const ViewerStatus& viewer : viewers) {
    EXPECT_EQ(viewer.address, "127.0.0.1");
    EXPECT_EQ(viewer.role, "operator");
  }
  EXPECT_GT(server_->figures().dropped, 20U);
  const std::string metrics = request(*server_, http::verb::get, "/metrics").body();
  EXPECT_THAT(metrics, HasSubstr("headway_up 1"));
  EXPECT_THAT(metrics, HasSubstr("headway_page_viewers 2"));
  EXPECT_THAT(metrics,
              HasSubstr(R"(headway_page_viewer_missed{viewer="2",role="operator",address="127.0.0.1"} 0)"));
}

TEST_F(ServerTest, APortThatIsTakenIsNamed) {
  begin();
  ServerConfig second;
  second.port = server_->port();
  try {
    Server other(second, flow_, clock_);
    FAIL();
  } catch (const InputError& fault) {
    EXPECT_THAT(fault.what(), HasSubstr("--port"));
  }
  second.address = "somewhere";
  EXPECT_THROW(Server(second, flow_, clock_), InputError);
}

}  // namespace
}  // namespace headway::remote
