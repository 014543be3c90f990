// What a plain HTTP request is answered, but for logging in and upgrades. No sockets.
#pragma once

#include <functional>
#include <string>

#include <boost/beast/http.hpp>

#include "operator/page_files.h"
#include "operator/source.h"

namespace headway::remote {

using Request = boost::beast::http::request<boost::beast::http::string_body>;
using Response = boost::beast::http::response<boost::beast::http::string_body>;

/// With the headers that every answer of ours has.
Response respond(const Request& request, boost::beast::http::status status, std::string body,
                 std::string_view mime = "text/plain; charset=utf-8");

/// Files of the page and whether the server is alive; all else is for those who were let in.
bool is_open_to_all(const Request& request, std::span<const PageFile> page);

/// A file of the page, what the source holds, or the metrics; 404 for all else, 405 for methods that change
/// something.
Response get(const Request& request, std::span<const PageFile> page, Source& source,
             const std::function<std::string()>& metrics);

}  // namespace headway::remote
