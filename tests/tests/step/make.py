"""Makes the STEP files of the tests: python make.py KIND UNIT FILE. Prints exact volume and surface, mm, as JSON."""

import json
import math
import sys

from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
from OCP.BRepGProp import BRepGProp
from OCP.BRepPrimAPI import (
    BRepPrimAPI_MakeBox,
    BRepPrimAPI_MakeCone,
    BRepPrimAPI_MakeCylinder,
    BRepPrimAPI_MakeSphere,
    BRepPrimAPI_MakeTorus,
)
from OCP.GProp import GProp_GProps
from OCP.Interface import Interface_Static
from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
from OCP.STEPCAFControl import STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_StepModelType
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS
from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool
from OCP.gp import gp_Ax1, gp_Ax2, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec

UP = gp_Dir(0, 0, 1)


def edges(shape):
    explorer = TopExp_Explorer(shape, TopAbs_ShapeEnum.TopAbs_EDGE)
    while explorer.More():
        yield TopoDS.Edge(explorer.Current())
        explorer.Next()


def bracket():
    """A plate with rounded edges and a bore, on it half a torus, half a sphere and a cone."""
    plate = BRepPrimAPI_MakeBox(80, 40, 10).Shape()
    rounded = BRepFilletAPI_MakeFillet(plate)
    for edge in edges(plate):
        rounded.Add(2.0, edge)
    bore = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(20, 20, -5), UP), 6, 30).Shape()
    shape = BRepAlgoAPI_Cut(rounded.Shape(), bore).Shape()
    for more in (
        BRepPrimAPI_MakeTorus(gp_Ax2(gp_Pnt(60, 20, 10), UP), 10, 2.5),
        BRepPrimAPI_MakeSphere(gp_Pnt(40, 20, 10), 5),
        BRepPrimAPI_MakeCone(gp_Ax2(gp_Pnt(60, 20, 9.9), UP), 5, 0, 15),
    ):
        shape = BRepAlgoAPI_Fuse(shape, more.Shape()).Shape()
    return shape


def moved(x, y, z, quarter_turns=0):
    placement = gp_Trsf()
    placement.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), UP), quarter_turns * math.pi / 2)
    placement.SetTranslationPart(gp_Vec(x, y, z))
    return TopLoc_Location(placement)


class Document:
    def __init__(self):
        self.document = TDocStd_Document(TCollection_ExtendedString("XmlOcaf"))
        self.shapes = XCAFDoc_DocumentTool.ShapeTool_s(self.document.Main())
        self.colours = XCAFDoc_DocumentTool.ColorTool_s(self.document.Main())

    def named(self, label, name, colour=None):
        TDataStd_Name.Set_s(label, TCollection_ExtendedString(name))
        if colour:
            colour = Quantity_Color(*colour, Quantity_TypeOfColor.Quantity_TOC_RGB)
            self.colours.SetColor(label, colour, XCAFDoc_ColorType.XCAFDoc_ColorGen)
        return label

    def part(self, name, shape, colour=None):
        return self.named(self.shapes.AddShape(shape, False), name, colour)

    def assembly(self, name, components):
        label = self.named(self.shapes.NewShape(), name)
        for own, part, location in components:
            self.named(self.shapes.AddComponent(label, part, location), own)
        return label

    def write(self, unit, path):
        self.shapes.UpdateAssemblies()
        writer = STEPCAFControl_Writer()
        Interface_Static.SetCVal_s("write.step.unit", unit)
        writer.Transfer(self.document, STEPControl_StepModelType.STEPControl_AsIs)
        writer.Write(path)


def main():
    kind, unit, path = sys.argv[1:]
    document = Document()
    shape = None
    if kind == "assembly":
        box = document.part("box", BRepPrimAPI_MakeBox(40, 30, 20).Shape(), (1.0, 0.0, 0.0))
        ring = document.part("ring", BRepPrimAPI_MakeTorus(30, 5).Shape())
        inner = document.assembly("frame", [("box", box, moved(100, 20, -7)), ("ring", ring, moved(0, 0, 50))])
        document.assembly("car", [("front", inner, moved(1000, 0, 3, 1)), ("spare", box, moved(-30, 5, 1))])
    elif kind == "twice":
        box = document.part("box", BRepPrimAPI_MakeBox(40, 30, 20).Shape())
        document.assembly("pair", [("box", box, moved(0, 0, 0)), ("box", box, moved(100, 0, 0))])
    elif kind == "wire":
        document.part("wire", BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(10, 0, 0)).Edge())
    elif kind == "sheet":
        box = document.part("box", BRepPrimAPI_MakeBox(40, 30, 20).Shape())
        faces = TopExp_Explorer(BRepPrimAPI_MakeBox(10, 10, 10).Shape(), TopAbs_ShapeEnum.TopAbs_FACE)
        sheet = document.part("sheet", faces.Current())
        document.assembly("pair", [("box", box, moved(0, 0, 0)), ("panel", sheet, moved(100, 0, 0))])
    elif kind == "touching":
        pair = [("a", moved(0, 0, 0)), ("b", moved(10, 0, 0))]
        cube = document.part("cube", BRepPrimAPI_MakeBox(10, 10, 10).Shape())
        document.assembly("pair", [(name, cube, place) for name, place in pair])
    else:
        shape = {
            "box": lambda: BRepPrimAPI_MakeBox(gp_Pnt(-125, -100, -60), 250, 200, 120).Shape(),
            "bracket": bracket,
            "sphere": lambda: BRepPrimAPI_MakeSphere(20).Shape(),
            "torus": lambda: BRepPrimAPI_MakeTorus(30, 5).Shape(),
        }[kind]()
        document.part(kind, shape)
    document.write(unit, path)
    if shape is not None:
        volume, area = GProp_GProps(), GProp_GProps()
        BRepGProp.VolumeProperties_s(shape, volume)
        BRepGProp.SurfaceProperties_s(shape, area)
        print(json.dumps({"volume": volume.Mass(), "area": area.Mass()}))


main()
