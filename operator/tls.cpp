#include "operator/tls.h"

#include <cerrno>
#include <fstream>
#include <system_error>

#include <fmt/format.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <sys/stat.h>

#include "hal/error.h"

namespace headway::remote {

namespace {

namespace ssl = boost::asio::ssl;

void require_readable(const char* option, const std::filesystem::path& file, const char* expected) {
  errno = 0;
  std::error_code ignored;
  if (!std::filesystem::is_directory(file, ignored) && std::ifstream(file)) return;
  throw InputError(fmt::format("{} {}: cannot be read ({}), expected {}", option, file.string(),
                               errno != 0 ? std::generic_category().message(errno) : "no file", expected));
}

/// The key is as good as every token.
void require_secret(const std::filesystem::path& key) {
  struct stat facts {};
  if (::stat(key.c_str(), &facts) == 0 && (facts.st_mode & S_IROTH) != 0)
    throw InputError(fmt::format(
        "--tls-key {}: everybody on this machine may read it; chmod o-r, or make another key", key.string()));
}

}  // namespace

std::unique_ptr<ssl::context> tls_context(const TlsFiles& files) {
  constexpr const char* kCertificate = "a certificate in PEM";
  constexpr const char* kKey = "its private key in PEM, without a password";
  require_readable("--tls-cert", files.certificate, kCertificate);
  require_readable("--tls-key", files.key, kKey);
  require_secret(files.key);
  auto context = std::make_unique<ssl::context>(ssl::context::tls_server);
  SSL_CTX_set_min_proto_version(context->native_handle(), TLS1_2_VERSION);
  context->set_options(ssl::context::no_compression | SSL_OP_NO_RENEGOTIATION);
  // Nobody sits at the vision computer who could type one.
  context->set_password_callback([](std::size_t, ssl::context::password_purpose) { return std::string(); });
  boost::system::error_code fault;
  context->use_certificate_chain_file(files.certificate.string(), fault);
  if (fault)
    throw InputError(fmt::format("--tls-cert {}: holds no certificate ({}), expected {}",
                                 files.certificate.string(), fault.message(), kCertificate));
  context->use_private_key_file(files.key.string(), ssl::context::pem, fault);
  if (fault && ERR_GET_LIB(static_cast<unsigned long>(fault.value())) == ERR_LIB_X509)
    throw InputError(fmt::format(
        "--tls-key {}: does not belong to the certificate {}; name the two that were made together",
        files.key.string(), files.certificate.string()));
  if (fault)
    throw InputError(fmt::format("--tls-key {}: holds no key that can be used ({}), expected {}",
                                 files.key.string(), fault.message(), kKey));
  return context;
}

}  // namespace headway::remote
