// SPDX-License-Identifier: MIT
#include "gravity_model.h"

#include <GeographicLib/GravityModel.hpp>
#include <fmt/core.h>

#include <exception>
#include <filesystem>
#include <stdexcept>

namespace gyrobudget::inline v0::earth {

namespace {

GeographicLib::GravityModel read(const std::string& path, int highest_degree) {
  const std::filesystem::path file(path);
  if (file.extension() != ".egm" || !file.has_stem())
    throw std::invalid_argument(fmt::format("gravity model '{}' must be a file that ends in .egm", path));
  if (highest_degree < 0)
    throw std::invalid_argument(fmt::format("highest degree {} of a gravity model must be 0 or more", highest_degree));
  const std::string folder = file.has_parent_path() ? file.parent_path().string() : ".";
  try {
    return GeographicLib::GravityModel(file.stem().string(), folder, highest_degree, highest_degree);
  } catch (const std::exception& e) {
    throw std::runtime_error(fmt::format("gravity model '{}': {}", path, e.what()));
  }
}

}  // namespace

struct GravityModel::Impl {
  Impl(const std::string& path, int highest_degree) : model(read(path, highest_degree)) {}

  GeographicLib::GravityModel model;  // cannot be copied: it points into its own coefficients
};

GravityModel::GravityModel(const std::string& path, int highest_degree)
    : impl_(std::make_shared<const Impl>(path, highest_degree)) {}

Eigen::Vector3d GravityModel::gravitation(const Eigen::Vector3d& p_eb_e) const {
  Eigen::Vector3d g;
  impl_->model.V(p_eb_e.x(), p_eb_e.y(), p_eb_e.z(), g.x(), g.y(), g.z());
  return g;
}

Eigen::Vector3d GravityModel::gravity(const Eigen::Vector3d& p_eb_e) const {
  Eigen::Vector3d g;
  impl_->model.W(p_eb_e.x(), p_eb_e.y(), p_eb_e.z(), g.x(), g.y(), g.z());
  return g;
}

std::string GravityModel::description() const { return impl_->model.Description(); }

}  // namespace gyrobudget::inline v0::earth
