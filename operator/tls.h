// The certificate and key that the page is served with.
#pragma once

#include <filesystem>
#include <memory>

#include <boost/asio/ssl/context.hpp>

namespace headway::remote {

struct TlsFiles {
  std::filesystem::path certificate, key;  ///< PEM; the certificate with those that vouch for it
};

/// For TLS 1.2 and newer. Throws InputError that names the file and the remedy, where one cannot be read,
/// others may read the key, or the two do not belong together.
std::unique_ptr<boost::asio::ssl::context> tls_context(const TlsFiles& files);

}  // namespace headway::remote
