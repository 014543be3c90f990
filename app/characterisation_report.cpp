#include "app/characterisation_report.h"

#include "hal/angle.h"

namespace headway::app {

namespace {

Json angles_json(const vision::FieldAngles& a) {
  return {{"horizontal_deg", rounded(a.horizontal / kDegree, 2)},
          {"vertical_deg", rounded(a.vertical / kDegree, 2)}};
}

Json vector_json(const Eigen::VectorXd& v, int decimals = 6) {
  Json out = Json::array();
  for (const double x : v) out.push_back(rounded(x, decimals));
  return out;
}

Json polytope_json(const vision::Polytope& polytope) {
  Json rows = Json::array(), corners = Json::array();
  for (const auto& row : polytope.rows) rows.push_back(vector_json(row));
  for (const auto& corner : polytope.corners) corners.push_back(vector_json(corner));
  return {{"rows", rows}, {"corners_m", corners}};
}

Json sizes_json(const std::array<vision::PolytopeSize, 3>& sizes) {
  return {{"no_limit", sizes[0].rows},
          {"near", sizes[1].rows},
          {"near_and_far", sizes[2].rows},
          {"corners", sizes[2].corners}};
}

Json tour_json(const CoveredTour& t) {
  return {{"laid_out_for", t.laid_out_for},
          {"views", t.views.size()},
          {"gaze_covered", {{"far", rounded(t.far_away.gaze)}, {"at_1_m", rounded(t.at_a_metre.gaze)}}},
          {"reach_covered", {{"far", rounded(t.far_away.reach)}, {"at_1_m", rounded(t.at_a_metre.reach)}}}};
}

}  // namespace

Json characterisation_report(const Characterisation& c) {
  Json out;
  out["rig"] = {{"name", c.raw.name},
                {"baseline_m", rounded(c.raw.baseline())},
                {"focal_px", rounded(c.rig.rectified.camera.focal, 3)},
                {"near_m", c.raw.nearest},
                {"far_m", c.raw.farthest},
                {"disparity_sigma_px", c.raw.disparity_sigma}};
  out["frame"] = kCharacterisedFrame;
  out["field"] = polytope_json(c.rig.field);
  out["field"]["volume_m3"] = rounded(vision::volume(c.rig.field));
  out["half_spaces"] = {{"rectified", sizes_json(c.rig.rectified_sizes)},
                        {"mounted", sizes_json(c.rig.mounted_sizes)}};
  out["matcher_without_padding"] = {{"columns", c.rig.matcher_columns},
                                    {"field_lost", rounded(c.rig.padded_share)}};
  out["pixel_pairs"] = {{"pairs", c.rig.pairs.pairs},
                        {"points", c.rig.pairs.points.size()},
                        {"hull_vertices", c.rig.pairs.hull.corners.size()},
                        {"hull_facets", c.rig.pairs.hull.rows.size()},
                        {"minimal_half_spaces", c.rig.pairs.minimal.rows.size()},
                        {"verified", vision::is_minimal(c.rig.pairs.minimal, 1e-6)},
                        {"paper", {{"hull_vertices", 250}, {"minimal_half_spaces", 132}}}};
  out["field_of_view"] = Json::array();
  for (const double z : telling_depths(c.raw)) {
    Json entry{{"depth_m", z < kFarAway ? rounded(z) : Json("far")}};
    entry.update(angles_json(vision::field_angles(c.rig.rectified, z)));
    out["field_of_view"].push_back(entry);
  }
  out["field_of_view_of_the_paper_deg"] = {33, 33};
  out["resolution"] = Json::array();
  for (const vision::SightAt& s : c.rig.sights)
    out["resolution"].push_back({{"depth_m", rounded(s.depth)},
                                 {"on_axis_mm", rounded(s.on_axis * 1e3, 3)},
                                 {"worst_mm", rounded(s.worst * 1e3, 3)},
                                 {"measured_mm", rounded(s.measured * 1e3, 3)}});
  out["fields_for_a_resolution"] = Json::array();
  for (const auto& r : c.rig.resolved)
    out["fields_for_a_resolution"].push_back({{"resolution_m", r.resolution},
                                              {"half_spaces", r.polytope.rows.size()},
                                              {"farthest_m", rounded(r.farthest)},
                                              {"volume_m3", rounded(vision::volume(r.polytope))}});
  out["viewpoints"] = Json::array();
  for (const CoveredTour& t : c.tours) out["viewpoints"].push_back(tour_json(t));
  return out;
}

}  // namespace headway::app
