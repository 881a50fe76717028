(<extruderInitialization>)
(<craftTypeName> extrusion </craftTypeName>)
(<creation> skeinforge </creation>)
(made of a mesh (of 12 faces (all of them triangles)), in 0.2 s)
M104 S220.0
G21
G90
G28
M103
M108 S210.0
(</extruderInitialization>)
(<crafting>)
(<layer> 0.4 )
(<nestedRing>)
(<perimeter> inner )
(<boundaryPoint> X31.0 Y31.0 Z0.4 </boundaryPoint>)
G1 X31.00 Y31.00 Z0.40 F2400
M101
G1 X49.00 Y31.00 F1800
G1 X49.00 Y49.00
G1 X31.00 Y49.00
G1 X31.00 Y31.00
M103
(</perimeter>)
(<perimeter> outer )
(<boundaryPoint> X30.0 Y30.0 Z0.4 </boundaryPoint>)
G1 X30.00 Y30.00 Z0.40 F2400
M101
G1 X50.00 Y30.00 F1800
G1 X50.00 Y50.00
G1 X30.00 Y50.00
G1 X30.00 Y30.00
M103
(</perimeter>)
(<infill>)
G1 X33.00 Y33.00 Z0.40 F2400
M101
G1 X47.00 Y33.00 F1800
G1 X47.00 Y37.67
G1 X33.00 Y37.67
G1 X33.00 Y42.33
G1 X47.00 Y42.33
G1 X47.00 Y47.00
G1 X33.00 Y47.00
M103
(</infill>)
(</nestedRing>)
(</layer>)
(<layer> 0.8 )
(<nestedRing>)
(<perimeter> inner )
(<boundaryPoint> X31.0 Y31.0 Z0.8 </boundaryPoint>)
G1 X31.00 Y31.00 Z0.80 F2400
M101
G1 X49.00 Y31.00 F1800
G1 X49.00 Y49.00
G1 X31.00 Y49.00
G1 X31.00 Y31.00
M103
(</perimeter>)
(<perimeter> outer )
(<boundaryPoint> X30.0 Y30.0 Z0.8 </boundaryPoint>)
G1 X30.00 Y30.00 Z0.80 F2400
M101
G1 X50.00 Y30.00 F1800
G1 X50.00 Y50.00
G1 X30.00 Y50.00
G1 X30.00 Y30.00
M103
(</perimeter>)
(<infill>)
G1 X33.00 Y33.00 Z0.80 F2400
M101
G1 X33.00 Y47.00 F1800
G1 X37.67 Y47.00
G1 X37.67 Y33.00
G1 X42.33 Y33.00
G1 X42.33 Y47.00
G1 X47.00 Y47.00
G1 X47.00 Y33.00
M103
(</infill>)
(</nestedRing>)
(</layer>)
(<layer> 1.2 )
(<nestedRing>)
(<perimeter> inner )
(<boundaryPoint> X31.0 Y31.0 Z1.2 </boundaryPoint>)
G1 X31.00 Y31.00 Z1.20 F2400
M101
G1 X49.00 Y31.00 F1800
G1 X49.00 Y49.00
G1 X31.00 Y49.00
G1 X31.00 Y31.00
M103
(</perimeter>)
(<perimeter> outer )
(<boundaryPoint> X30.0 Y30.0 Z1.2 </boundaryPoint>)
G1 X30.00 Y30.00 Z1.20 F2400
M101
G1 X50.00 Y30.00 F1800
G1 X50.00 Y50.00
G1 X30.00 Y50.00
G1 X30.00 Y30.00
M103
(</perimeter>)
(<infill>)
G1 X33.00 Y33.00 Z1.20 F2400
M101
G1 X47.00 Y33.00 F1800
G1 X47.00 Y37.67
G1 X33.00 Y37.67
G1 X33.00 Y42.33
G1 X47.00 Y42.33
G1 X47.00 Y47.00
G1 X33.00 Y47.00
M103
(</infill>)
(</nestedRing>)
(</layer>)
(</crafting>)
G1 Z30.0 F300.0
M104 S0
