// SPDX-License-Identifier: Apache-2.0
// Textures, decoded by Hio, each once.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "irt/texture/texture.h"
#include "pxr/usd/sdf/assetPath.h"
#include "pxr/usd/sdf/path.h"

PXR_NAMESPACE_OPEN_SCOPE

struct HdIrtTexture {
    std::shared_ptr<const irt::Texture> texture;  ///< null: its fallback is rendered
    irt::Wrap wrap_s = irt::Wrap::Black, wrap_t = irt::Wrap::Black;
};

class HdIrtTextures {
  public:
    /// `space` is "raw", "sRGB" or "auto", the wraps are UsdUVTexture's. `node`, of what needs it,
    /// begins warnings. Thread-safe.
    HdIrtTexture Find(const SdfAssetPath& file, const std::string& space, const std::string& wrap_s,
                      const std::string& wrap_t, const SdfPath& node);

  private:
    /// A file, and the wraps that its metadata has.
    struct Loaded {
        std::weak_ptr<const irt::Texture> texture;
        irt::Wrap wrap_s, wrap_t;
    };

    std::mutex _mutex;
    std::map<std::pair<std::string, std::string>, Loaded> _loaded;  ///< by file and space
};

PXR_NAMESPACE_CLOSE_SCOPE
