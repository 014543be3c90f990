#include "operator/http.h"

#include <algorithm>
#include <optional>

#include <zlib.h>

namespace headway::remote {

namespace {

namespace http = boost::beast::http;

constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src "
    "'self'; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

std::string_view view(boost::beast::string_view text) { return {text.data(), text.size()}; }

/// For the few clients that take no gzip.
std::string unzipped(std::span<const unsigned char> gzip) {
  z_stream stream{};
  std::string out;
  if (inflateInit2(&stream, 16 + MAX_WBITS) != Z_OK) return out;
  stream.next_in = const_cast<unsigned char*>(gzip.data());
  stream.avail_in = static_cast<uInt>(gzip.size());
  std::array<char, 16384> some;
  int state = Z_OK;
  while (state == Z_OK) {
    stream.next_out = reinterpret_cast<Bytef*>(some.data());
    stream.avail_out = static_cast<uInt>(some.size());
    state = inflate(&stream, Z_NO_FLUSH);
    out.append(some.data(), some.size() - stream.avail_out);
  }
  inflateEnd(&stream);
  return out;
}

Response page_file(const Request& request, const PageFile& file) {
  const std::string etag(file.etag);
  if (view(request[http::field::if_none_match]) == file.etag) {
    Response unchanged = respond(request, http::status::not_modified, "", file.mime);
    unchanged.set(http::field::etag, etag);
    return unchanged;
  }
  const bool takes_gzip = view(request[http::field::accept_encoding]).find("gzip") != std::string_view::npos;
  Response response =
      respond(request, http::status::ok,
              takes_gzip ? std::string(reinterpret_cast<const char*>(file.gzip.data()), file.gzip.size())
                         : unzipped(file.gzip),
              file.mime);
  if (takes_gzip) response.set(http::field::content_encoding, "gzip");
  response.set(http::field::vary, "Accept-Encoding");
  response.set(http::field::etag, etag);
  return response;
}

std::string_view path_of(const Request& request) {
  const std::string_view target = view(request.target());
  return target.substr(0, target.find('?'));
}

auto page_file_at(std::string_view path, std::span<const PageFile> page) {
  return std::ranges::find(page, path == "/" ? "/index.html" : path, &PageFile::path);
}

}  // namespace

bool is_open_to_all(const Request& request, std::span<const PageFile> page) {
  const std::string_view path = path_of(request);
  return path == "/" || path == "/healthz" || page_file_at(path, page) != page.end();
}

Response respond(const Request& request, http::status status, std::string body, std::string_view mime) {
  Response response{status, request.version()};
  response.set(http::field::server, "Headway");
  response.set(http::field::content_type, std::string(mime));
  response.set(http::field::cache_control, "no-cache");
  response.set("Content-Security-Policy", kPolicy);
  response.set("X-Content-Type-Options", "nosniff");
  response.set("Referrer-Policy", "no-referrer");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.keep_alive(request.keep_alive());
  const bool head = request.method() == http::verb::head;
  const std::size_t size = body.size();
  if (!head) response.body() = std::move(body);
  response.content_length(size);
  return response;
}

Response get(const Request& request, std::span<const PageFile> page, Source& source,
             const std::function<std::string()>& metrics) {
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    Response refused = respond(request, http::status::method_not_allowed, "expected GET\n");
    refused.set(http::field::allow, "GET, HEAD");
    return refused;
  }
  const std::string_view path = path_of(request);
  const auto file = page_file_at(path, page);
  if (file != page.end()) return page_file(request, *file);
  if (path == "/") return respond(request, http::status::ok, "Headway was built without its page.\n");
  if (path == "/healthz") return respond(request, http::status::ok, "ok\n");
  if (path == "/metrics")
    return respond(request, http::status::ok, metrics(), "text/plain; version=0.0.4; charset=utf-8");
  for (const std::string name : {"map.pgm", "map.yaml", "map.bt"})
    if (path == "/" + name) {
      const auto content = source.file(name);
      if (!content) return respond(request, http::status::not_found, name + ": there is none yet\n");
      return respond(request, http::status::ok, *content,
                     name == "map.yaml" ? "text/plain; charset=utf-8" : "application/octet-stream");
    }
  return respond(request, http::status::not_found, "there is no such page\n");
}

}  // namespace headway::remote
