"""Cases that are refused, with the place and the rule. Points and degenerate faces are no reason to."""

import json

from document import Gltf, obj, soup
from formats import HEAD, MTL, PLACES, SQUARE, UNIT, zipped
from pictures import bomb, quadrants, ramp


def refused(code, pointer, detail, **more):
    return {"/error/code": code, "/error/pointer": pointer, "detail_contains": detail, **more}


def document(change=None, vertices=None, indices=None, picture=None):
    gltf = Gltf()
    gltf.material(picture or ramp(8))
    own = soup([UNIT])
    gltf.mesh(gltf.primitive(vertices or own[0], indices or own[1]))
    if change:
        change(gltf.json)
    return {"model.gltf": gltf.bytes()}


def uris(cases):
    def add(name, purpose, uri, code, detail):
        def change(json):
            json["images"][0] = {"uri": uri}
        cases[name] = (purpose, document(change), refused(code, "/images/0/uri", detail))

    add("bad_uri_climbs", "An image above the model's folder", "../secret.png", "unsafe_uri", "`..`")
    add("bad_uri_encoded", "The same, percent-encoded", "%2e%2e/secret.png", "unsafe_uri", "`..`")
    add("bad_uri_absolute", "An absolute path", "/etc/passwd", "unsafe_uri", "absolute path")
    add("bad_uri_file", "A file URI", "file:///etc/passwd", "unsafe_uri", "scheme")
    add("bad_uri_external", "An image on the network", "https://example.com/a.png", "external_uri", "network")
    add("bad_uri_missing", "A file that is not there", "paint.png", "missing_resource", "\"model.gltf\"")
    files = {"model.obj": obj(SQUARE, [[0, 1, 2, 3]], PLACES, HEAD), "paint.mtl": b"newmtl paint\nmap_Kd ../../a.png\n"}
    cases["bad_mtl_climbs"] = ("A map of an MTL file above the folder", files, refused("unsafe_uri", "paint.mtl:2", "`..`"))
    files = {"model.zip": zipped({"model.obj": b"v 0 0 0\n", "../outside.obj": b"v 0 0 0\n"})}
    cases["bad_zip_climbs"] = ("An archive with a name that leaves it", files,
                               refused("unsafe_uri", 'zip entry "../outside.obj"', "`..`"))


def numbers(cases):
    vertices, indices = soup([UNIT])
    odd = [((float("nan"), 0, 0), vertices[0][1])] + vertices[1:]
    cases["bad_nan_position"] = ("A position that is not a number", document(vertices=odd),
                                 refused("invalid_model", "/accessors/0", "NaN"))
    odd = [(vertices[0][0], (float("inf"), 0))] + vertices[1:]
    cases["bad_infinite_texcoord"] = ("An infinite texture coordinate", document(vertices=odd),
                                      refused("invalid_model", "/accessors/1", "inf"))
    cases["bad_index"] = ("An index beyond the last vertex", document(indices=indices[:-1] + [4]),
                          refused("invalid_model", "/accessors/2", "4"))

    def accessor(json):
        json["accessors"][0]["count"] = 5000
    cases["bad_accessor_range"] = ("An accessor longer than its view", document(accessor),
                                   refused("invalid_model", "/accessors/0", "5000"))
    text = obj(SQUARE, [[0, 1, 2, 8]], PLACES[:3] + [(0, 1)])
    cases["bad_obj_index"] = ("An OBJ face with a vertex that is not there", {"model.obj": text},
                              refused("invalid_model", "model.obj:9", "9"))


def graph(cases):
    def cycle(json):
        json["nodes"] = [{"mesh": 0}, {"children": [2]}, {"children": [1]}]
    cases["bad_node_cycle"] = ("Two nodes that are each other's child", document(cycle),
                               refused("invalid_model", "/nodes/1", "ancestor"))

    def extension(json):
        json["extensionsUsed"] = json["extensionsRequired"] = ["VENDOR_unknown"]
    cases["bad_extension"] = ("A required extension that is not understood", document(extension),
                              refused("unsupported_extension", "/extensionsRequired/0", "VENDOR_unknown"))

    def untextured(json):
        del json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]
    cases["bad_nothing_to_convert"] = ("A model without a texture", document(untextured),
                                       refused("nothing_to_convert", "/materials", "textured"))


def containers(cases):
    huge = {"/error/limit": 16384, "/error/actual": 60000}
    cases["bad_image_bomb"] = ("An image header that asks for 60000 by 60000", document(picture=bomb(60000)),
                               refused("image_too_large", "/images/0", "60000x60000", **huge))
    cases["bad_image_cut_short"] = ("An image that ends in the middle", document(picture=quadrants()[:200]),
                                    refused("invalid_model", "/images/0", "decoded"))
    cases["bad_image_format"] = ("An image in a format that is not read", document(picture=b"GIF89a" + bytes(20)),
                                 refused("unsupported_media_type", "/images/0", "PNG"))
    cases["bad_json"] = ("A document that ends in the middle", {"model.gltf": document()["model.gltf"][:300]},
                         refused("invalid_model", None, "JSON"))
    cases["bad_glb_length"] = ("A GLB that is shorter than it says", {"model.glb": b"glTF\2\0\0\0\xff\0\0\0" + bytes(20)},
                               refused("invalid_model", None, "255"))
    cases["bad_container"] = ("A file of no known kind", {"model.bin": bytes(range(200, 240))},
                              refused("unsupported_media_type", None, "glTF"))
    cases["bad_texture_size"] = ("A layout beyond the largest texture", document(),
                                 refused("texture_too_large", None, "--resolution"), {"resolution": "fixed:12"},
                                 {"texture_side": 2048})


def add(cases):
    for group in (uris, numbers, graph, containers):
        group(cases)
