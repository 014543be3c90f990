// The floor made ready for the search. Between two maps only what has changed is worked on.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "nav/cell_bits.h"
#include "nav/floor_chunks.h"
#include "nav/floor_prices.h"
#include "nav/ground.h"
#include "nav/mask_dilation.h"
#include "nav/masks.h"

namespace headway::nav {

class SurveyedFloor {
 public:
  /// The masks of the whole body and of the bare one, which alone must keep off tight ground. Where the whole
  /// body's mask meets low ground the only motion is straight on.
  SurveyedFloor(const Masks& masks, const Masks& bare_masks, const FloorPrices& prices, UnseenFloor unseen)
      : dilation_(masks), bare_dilation_(bare_masks), prices_(prices), unseen_(unseen) {}

  /// Takes in a map as seen from a start. What has changed holds until the next update.
  const FloorChanges& update(const FloorMap& map, const GroundView& view);
  /// The next map counts as the first one.
  void forget() { raster_ = {}; }

  const FloorChunks& chunks() const { return chunks_; }
  const GroundRaster& raster() const { return raster_; }
  const FloorPrices& prices() const { return prices_; }
  std::size_t bytes() const;

 private:
  void begin(const FloorMap& map);
  void compare(const FloorMap& map);
  void take_row(const FloorMap& map, int y, int first, int last);
  void change(int x, int y, Ground ground);
  void look_near(const GroundView& view, const CellBox& box);
  void rework();
  void rework(const CellBox& changed);
  void price_low_ground(const CellBox& chunks);
  void remember(const CellBox& chunks);  ///< of `chunks`, x counts chunks
  void list_changes(const CellBox& chunks);

  MaskDilation dilation_, bare_dilation_;
  FloorPrices prices_;
  UnseenFloor unseen_;

  std::vector<Floor> map_;  ///< as it was last
  std::vector<Ground> ground_;
  GroundRaster raster_;
  CellBits blocked_, tight_, low_;
  int tight_cells_ = 0, low_cells_ = 0;
  CellBox near_;  ///< where the start mattered last
  struct Span {
    int first, last;
  };
  std::vector<Span> changed_;  ///< cells of each row
  FloorChunks chunks_;
  std::vector<FloorChunk> before_;  ///< of the chunks that are reworked
  FloorChanges changes_;
};

}  // namespace headway::nav
