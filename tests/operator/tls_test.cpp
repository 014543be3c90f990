// The page over TLS, with a certificate that the test makes.
#include "operator/tls.h"

#include <chrono>

#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include "tests/operator/server_bench.h"

namespace headway::remote {

namespace ssl = asio::ssl;
using TlsStream = ssl::stream<tcp::socket>;

namespace {

template <class T, void (*kFree)(T*)>
struct Freed {
  void operator()(T* what) const { kFree(what); }
};
using Key = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY, EVP_PKEY_free>>;
using Certificate = std::unique_ptr<X509, Freed<X509, X509_free>>;

void put(const std::filesystem::path& file, const std::function<void(FILE*)>& write) {
  FILE* out = std::fopen(file.c_str(), "w");
  ASSERT_TRUE(out);
  write(out);
  std::fclose(out);
  std::filesystem::permissions(file,
                               std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
}

/// A self-signed certificate for 127.0.0.1, and its key, as NAME.pem and NAME.key.
TlsFiles made(const std::filesystem::path& folder, const std::string& name) {
  const Key key(EVP_EC_gen("P-256"));
  const Certificate certificate(X509_new());
  X509* x = certificate.get();
  X509_set_version(x, 2);
  ASN1_INTEGER_set(X509_get_serialNumber(x), 1);
  X509_gmtime_adj(X509_getm_notBefore(x), -60);
  X509_gmtime_adj(X509_getm_notAfter(x), 3600);
  X509_set_pubkey(x, key.get());
  X509_NAME_add_entry_by_txt(X509_get_subject_name(x), "CN", MBSTRING_ASC,
                             reinterpret_cast<const unsigned char*>("127.0.0.1"), -1, -1, 0);
  X509_set_issuer_name(x, X509_get_subject_name(x));
  X509_sign(x, key.get(), EVP_sha256());
  const TlsFiles files{folder / (name + ".pem"), folder / (name + ".key")};
  put(files.certificate, [&](FILE* out) { PEM_write_X509(out, x); });
  put(files.key,
      [&](FILE* out) { PEM_write_PrivateKey(out, key.get(), nullptr, nullptr, 0, nullptr, nullptr); });
  return files;
}

class TlsTest : public ServerTest {
 protected:
  void begin_encrypted(bool with_token = false) {
    files_ = made(folder_, "server");
    ServerConfig config;
    config.tls = files_;
    config.require_token = with_token;
    begin(config);
    context_.load_verify_file(files_.certificate.string());
    context_.set_verify_mode(ssl::verify_peer);
  }
  TlsStream connect() {
    TlsStream stream(io_, context_);
    stream.next_layer().connect({asio::ip::make_address("127.0.0.1"), server_->port()});
    stream.handshake(ssl::stream_base::client);
    return stream;
  }
  Response encrypted(http::verb verb, const std::string& target, const std::string& body = "") {
    TlsStream stream = connect();
    Request request{verb, target, 11};
    request.set(http::field::host, fmt::format("127.0.0.1:{}", server_->port()));
    if (!body.empty()) request.set(http::field::content_type, "application/json");
    request.body() = body;
    request.prepare_payload();
    http::write(stream, request);
    beast::flat_buffer buffer;
    Response response;
    http::read(stream, buffer, response);
    return response;
  }
  /// Why it does not begin with such files.
  std::string fault(const TlsFiles& files) {
    ServerConfig config;
    config.tls = files;
    try {
      begin(config);
    } catch (const InputError& said) {
      return said.what();
    }
    return "it began";
  }

  TlsFiles files_;
  asio::io_context io_;
  ssl::context context_{ssl::context::tls_client};
};

TEST_F(TlsTest, ThePageItsCookieAndItsAddressAreEncrypted) {
  begin_encrypted(true);
  EXPECT_TRUE(server_->address_to_open().starts_with("https://127.0.0.1:")) << server_->address_to_open();
  const Response page = encrypted(http::verb::get, "/");
  EXPECT_EQ(page.result_int(), 200U);
  const Response in = encrypted(http::verb::post, "/login", Json{{"token", tokens_.operate}}.dump());
  EXPECT_EQ(in.result_int(), 204U);
  const std::string cookie(in[http::field::set_cookie]);
  EXPECT_THAT(cookie, HasSubstr("; Secure"));
  EXPECT_THAT(cookie, HasSubstr("; HttpOnly"));
}

TEST_F(TlsTest, ViewersTalkThroughItInBothDirections) {
  flow_.size_ = 300'000;
  begin_encrypted();
  websocket::stream<TlsStream> socket(connect());
  socket.set_option(websocket::stream_base::decorator([](websocket::request_type& request) {
    request.set(http::field::sec_websocket_protocol, "foxglove.sdk.v1");
    request.set(http::field::origin, "https://" + std::string(request[http::field::host]));
  }));
  socket.handshake(fmt::format("127.0.0.1:{}", server_->port()), "/ws");
  const auto hear = [&] {
    beast::flat_buffer buffer;
    socket.read(buffer);
    return beast::buffers_to_string(buffer.data());
  };
  for (int i = 0; i < 3; ++i) EXPECT_EQ(hear().front(), '{');
  const auto picture = static_cast<std::size_t>(Channel::kPicture);
  socket.text(true);
  socket.write(asio::buffer(
      Json{{"op", "subscribe"}, {"subscriptions", {{{"id", 5}, {"channelId", picture}}}}}.dump()));
  for (int i = 0; i < 5; ++i) EXPECT_GT(hear().size(), 300'000U);
  socket.binary(true);
  socket.write(asio::buffer(Talker::call_bytes(Talker::service("ping"), 1, "{}")));
  EXPECT_TRUE(until([&] { return hear().front() == '\3'; }));
}

TEST_F(TlsTest, WhatIsNotEncryptedGetsOneAnswerThatSaysSo) {
  begin_encrypted();
  const Response plain = request(*server_, http::verb::get, "/map.pgm");
  EXPECT_EQ(plain.result_int(), 400U);
  EXPECT_EQ(plain.body(),
            fmt::format("this server is encrypted: open https://127.0.0.1:{}/\n", server_->port()));
  EXPECT_EQ(upgrade(*server_), 400);
  EXPECT_EQ(code(*server_, http::verb::post, "/login", {{"Content-Type", "application/json"}}, "{}"), 400);
  Raw noise(*server_);
  noise.send(std::string("\x16\x03\x01\x00\x05", 5) + "hello");
  noise.receive();
  Raw half(*server_);
  half.send("\x16");
  EXPECT_EQ(half.receive(), "") << "who goes on for ever is hung up on";
  EXPECT_EQ(encrypted(http::verb::get, "/healthz").result_int(), 200U) << "others are served";
}

TEST_F(TlsTest, OldVersionsAreNotSpoken) {
  begin_encrypted();
  SSL_CTX_set_security_level(context_.native_handle(), 0);
  SSL_CTX_set_max_proto_version(context_.native_handle(), TLS1_1_VERSION);
  EXPECT_THROW(connect(), boost::system::system_error);
}

TEST_F(TlsTest, FilesThatCannotBeUsedAreNamedWithTheRemedy) {
  const TlsFiles good = made(folder_, "good"), other = made(folder_, "other");
  EXPECT_EQ(fault(good), "it began");
  const std::string missing = (folder_ / "missing.pem").string();
  EXPECT_THAT(fault({missing, good.key}),
              HasSubstr("--tls-cert " + missing + ": cannot be read (No such file"));
  EXPECT_THAT(fault({good.certificate, missing}), HasSubstr("--tls-key " + missing + ": cannot be read"));
  EXPECT_THAT(fault({folder_, good.key}), HasSubstr("cannot be read"));
  const std::string mismatch = fault({good.certificate, other.key});
  EXPECT_THAT(mismatch, HasSubstr("does not belong to the certificate " + good.certificate.string()));
  EXPECT_THAT(mismatch, HasSubstr("--tls-key " + other.key.string()));
  EXPECT_THAT(fault({good.key, good.key}), HasSubstr("holds no certificate"));
  EXPECT_THAT(fault({good.certificate, good.certificate}), HasSubstr("holds no key that can be used"));
  std::filesystem::permissions(good.key, std::filesystem::perms::others_read,
                               std::filesystem::perm_options::add);
  EXPECT_THAT(fault(good), HasSubstr("chmod o-r"));
}

}  // namespace
}  // namespace headway::remote
