#include "app/command_map_convert.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "app/finite_range.h"
#include "app/standard_streams.h"
#include "hal/error.h"
#include "nav/cold_map.h"
#include "nav/cold_map_file.h"
#include "nav/floor_columns.h"
#include "nav/floor_files.h"
#include "nav/octomap_files.h"
#include "nav/voxel_cloud_file.h"
#include "runtime/durable_file.h"

namespace headway::app {
namespace {

namespace fs = std::filesystem;

struct ConvertOptions {
  fs::path in, out;
  std::optional<double> resolution;
  std::optional<double> floor, height;
};

constexpr double kHeight = 1.7;  // of the columns on a floor map's blocked cells [m]

nav::SavedMap read_floor(const ConvertOptions& options) {
  const nav::FloorMap floor = nav::read_map_server(fs::path(options.in).replace_extension(".yaml"));
  const Eigen::Array2d first = floor.grid.origin.array() / floor.grid.resolution;
  const double shift = (first - first.round()).abs().maxCoeff() * floor.grid.resolution;
  if (shift > 1e-6) fmt::print("cells move by {:.3f} m, onto the grid of the voxels\n", shift);
  return nav::raise_floor(floor, options.height.value_or(kHeight));
}

/// Throws InputError where NAME.yaml, which comes with every NAME.pgm, would go over a file of another kind.
void refuse_to_write_over(const fs::path& yaml) {
  std::error_code ignored;
  if (!fs::exists(yaml, ignored)) return;
  std::string fault;
  try {
    nav::read_map_server(yaml);
    return;
  } catch (const InputError& error) {
    fault = error.what();
  }
  throw InputError(fmt::format(
      "{}: would be written over, though it is no floor map: {}; choose another name, or remove it first",
      yaml.string(), fault));
}

void write_floor(const nav::SavedMap& saved, const ConvertOptions& options) {
  refuse_to_write_over(fs::path(options.out).replace_extension(".yaml"));
  const fs::path folder = options.out.has_parent_path() ? options.out.parent_path() : fs::path(".");
  const double height = options.floor.value_or(0);
  const nav::FloorMap floor = nav::floor_below(saved.map, {}, height);
  if (std::ranges::find(floor.cells, nav::Floor::kFree) == floor.cells.end()) {
    say_error("headway: {}: no cell of it is free; is its floor at z = {} m? --floor says where\n",
              options.out.string(), height);
  }
  nav::write_map_server(floor, folder, options.out.stem().string());
}

/// How a format is read and written, and what does not survive it.
struct Format {
  std::string_view extension;
  nav::SavedMap (*read)(const ConvertOptions&);
  void (*write)(const nav::SavedMap&, const ConvertOptions&);
  std::string_view loses;
};

constexpr std::string_view kFloorLoses = "heights: .pgm and .yaml keep only the floor seen from above";
constexpr std::string_view kOwn = ".hmap";
constexpr std::array<Format, 6> kFormats{{
    {kOwn, [](const ConvertOptions& o) { return nav::read_saved_map(o.in); },
     [](const nav::SavedMap& saved, const ConvertOptions& o) {
       runtime::write_durably(
           o.out, [&](std::ostream& out) { nav::write_map_file(saved.map, saved.surfaces, out); });
     },
     ""},
    {".ot", [](const ConvertOptions& o) { return nav::SavedMap(nav::read_ot(o.in)); },
     [](const nav::SavedMap& saved, const ConvertOptions& o) { nav::write_ot(saved.map, o.out); }, ""},
    {".bt", [](const ConvertOptions& o) { return nav::SavedMap(nav::read_bt(o.in)); },
     [](const nav::SavedMap& saved, const ConvertOptions& o) { nav::write_bt(saved.map, o.out); },
     "how sure each voxel is; .bt keeps only occupied or empty"},
    {".ply", [](const ConvertOptions& o) { return nav::SavedMap(nav::read_voxel_cloud(o.in, o.resolution)); },
     [](const nav::SavedMap& saved, const ConvertOptions& o) { nav::write_voxel_cloud(saved.map, o.out); },
     "the empty voxels; .ply keeps only the occupied ones"},
    {".pgm", read_floor, write_floor, kFloorLoses},
    {".yaml", read_floor, write_floor, kFloorLoses},
}};

const Format& format_of(const fs::path& file) {
  for (const Format& format : kFormats) {
    if (file.extension() == format.extension) return format;
  }
  throw InputError(
      fmt::format("{}: expected a name that ends with .hmap, .ot, .bt, .ply, .pgm or .yaml", file.string()));
}

/// Known voxels of a map.
struct Counts {
  std::size_t occupied = 0, empty = 0;
};

Counts count(const nav::ColdMap& map) {
  Counts counts;
  map.for_any([&](const nav::BrickKey&, const nav::BrickValues& values) {
    for (const nav::LogOdds v : values) {
      counts.occupied += v >= nav::log_odds::kOccupied;
      counts.empty += v < nav::log_odds::kOccupied && v != nav::log_odds::kUnseen;
    }
  });
  return counts;
}

std::string what_is_lost(const Format& from, const Format& to, const nav::SavedMap& saved) {
  std::string lost(to.loses == from.loses ? "" : to.loses);
  if (saved.surfaces.voxels() > 0 && to.extension != kOwn)
    lost = fmt::format("where within voxels surfaces lie{}{}", lost.empty() ? "" : ", and without ", lost);
  return lost.empty() ? "" : ", without " + lost;
}

bool is_floor(const fs::path& file) { return file.extension() == ".pgm" || file.extension() == ".yaml"; }

/// Throws InputError for an option that would do nothing.
void refuse_idle(const ConvertOptions& options) {
  const auto refuse = [](bool given, const char* option, const char* what, const fs::path& file) {
    if (given)
      throw InputError(fmt::format("map convert: {} is for {}, which {} is not; leave it out", option, what,
                                   file.string()));
  };
  refuse(options.resolution && options.in.extension() != ".ply", "--resolution", "points (.ply)", options.in);
  refuse(options.height && !is_floor(options.in), "--height", "IN a floor map (.pgm, .yaml)", options.in);
  refuse(options.floor && !is_floor(options.out), "--floor", "OUT a floor map (.pgm, .yaml)", options.out);
}

/// Throws InputError where OUT is IN: what its format loses would be lost for good.
void refuse_same(const ConvertOptions& options) {
  const auto file = [](fs::path path) {
    if (is_floor(path)) path.replace_extension(".yaml");
    std::error_code ignored;
    return fs::weakly_canonical(path, ignored);
  };
  if (file(options.in) == file(options.out)) {
    throw InputError(fmt::format("map convert: OUT, {}, would be written over IN; choose another name",
                                 options.out.string()));
  }
}

int convert(const ConvertOptions& options) {
  const Format &from = format_of(options.in), &to = format_of(options.out);
  refuse_idle(options);
  refuse_same(options);
  const nav::SavedMap saved = from.read(options);
  const nav::ColdMap& map = saved.map;
  to.write(saved, options);
  const Counts counts = count(map);
  fmt::print("{}: {} occupied and {} empty voxels of {} m, in {} bricks\n", options.in.string(),
             counts.occupied, counts.empty, map.resolution(), map.size());
  const auto written = [&] {
    const fs::path& out = options.out;
    if (!is_floor(out)) return out.string();
    return fs::path(out).replace_extension(".pgm").string() + " and " +
           fs::path(out).replace_extension(".yaml").string();
  };
  fmt::print("{}: written{}\n", written(), what_is_lost(from, to, saved));
  return kSuccess;
}

}  // namespace

void add_map_convert(CLI::App& map, Run& run) {
  auto options = std::make_shared<ConvertOptions>();
  CLI::App* command = map.add_subcommand("convert", "Turns a map from one file format into another.");
  command->footer(
      "What IN and OUT end with says which format they have, and what it keeps:\n"
      "  .hmap        Headway's own: all there is, with a checksum; written so that a crash leaves the old "
      "file\n"
      "  .ot          OctoMap's full tree: all there is, but not where within voxels surfaces lie\n"
      "  .bt          OctoMap's binary tree: occupied or empty, but not how sure\n"
      "  .ply         points: the occupied voxels. Any cloud with x, y and z is read, each point as a hit;\n"
      "               give --resolution where it is no map of Headway's\n"
      "  .pgm, .yaml  map_server's pair (either name stands for both): the floor seen from above, and what\n"
      "               stands on it up to 1.7 m. Read, blocked cells become columns as high as --height says\n"
      "One line says what OUT cannot keep.\n"
      "Examples: headway map convert build/map/map.bt map.hmap\n"
      "          headway map convert build/map/cloud.ply map.ot --resolution 0.05\n"
      "          headway map convert map.hmap floor.yaml");
  command->add_option("in", options->in, "The map that is there")->required()->type_name("IN");
  command->add_option("out", options->out, "The map to write")->required()->type_name("OUT");
  command
      ->add_option("--resolution", options->resolution, "Edge of the voxels that the points of a .ply go to")
      ->check(finite_in(nav::ColdMap::kFinest, nav::ColdMap::kCoarsest))
      ->type_name("M");
  command
      ->add_option("--floor", options->floor, "Height of the floor in IN, for OUT .pgm or .yaml; default: 0")
      ->check(finite_in(-10000, 10000))
      ->type_name("M");
  command
      ->add_option("--height", options->height,
                   fmt::format("Height of the columns raised from IN .pgm or .yaml; default: {}", kHeight))
      ->check(finite_in(0.001, 100))
      ->type_name("M");
  command->callback([options, &run] { run = [options] { return convert(*options); }; });
}

}  // namespace headway::app
