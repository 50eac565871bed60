"""Robots of other tools with what those tools allow and no free flyer has."""

import re
from collections.abc import Mapping
from random import Random

import mutations
from case import Case
from mutations import spoiled
from seeds import Seeds

PIECES: Mapping[str, tuple[str, ...]] = {
    "robot.xml": (
        '<asset><model name="again" file="robot.xml"/></asset><worldbody><attach '
        'model="again" body="part0" prefix="p_"/></worldbody>',
        '<include file="robot.xml"/>',
        '<include file="../none.xml"/>',
        '<size {size}="{count}"/>',
        '<worldbody><replicate count="{count}"><body><geom size="1"/></body>'
        "</replicate></worldbody>",
        '<asset><hfield name="h" nrow="{count}" ncol="{count}" size="1 1 1 1"/></asset>'
        '<worldbody><geom type="hfield" hfield="h"/></worldbody>',
        '<asset><texture name="t" type="2d" builtin="flat" width="{count}" '
        'height="{count}"/></asset>',
        '<asset><mesh name="m" file="robot.xml"/></asset>',
        '<worldbody><body><freejoint/><composite type="particle" '
        'count="{count} {count} {count}" spacing="1"/></body></worldbody>',
        '<worldbody><flexcomp name="f" type="grid" count="{count} 4 4" spacing=".1 .1 '
        '.1" mass="1"/></worldbody>',
        '<equality><joint joint1="to_part1" joint2="to_part2" polycoef="{number} '
        '{number} {number} 0 0"/></equality>',
        '<equality><connect body1="part0" body2="part4" anchor="0 0 0"/></equality>',
        '<equality><weld body1="part1" body2="part1"/></equality>',
        '<tendon><fixed name="t"><joint joint="to_part1" coef="{number}"/></fixed>'
        '</tendon><equality><tendon tendon1="t"/></equality>',
        '<compiler settotalmass="{number}" balanceinertia="true" '
        'boundmass="{number}"/>',
        '<compiler inertiafromgeom="true" discardvisual="true" fusestatic="true"/>',
        '<option timestep="{number}" gravity="{number} 0 0"/>',
        '<keyframe><key qpos="{number}"/></keyframe>',
        '<default><joint armature="{number}" range="{number} 1"/></default>',
        '<extension><plugin plugin="mujoco.pid"/></extension>',
        '<custom><numeric name="n" size="{count}" data="1"/></custom>',
        '<worldbody><body mocap="true"/><light/><camera/></worldbody>',
        '<worldbody><body><joint type="ball"/><freejoint/></body></worldbody>',
    ),
    "robot.sdf": (
        "<include><uri>robot.sdf</uri></include>",
        "<include><uri>model://none</uri><pose>{number} 0 0 0 0 0</pose></include>",
        "<model name='again'><link name='part0'/></model>",
        "<frame name='f' attached_to='f'/>",
        "<frame name='f' attached_to='g'/><frame name='g' attached_to='f'/>",
        "<pose relative_to='part4'>0 0 0 0 0 {number}</pose>",
        "<link name='auto'><inertial auto='true'><density>{number}</density></inertial>"
        "<collision name='c'><geometry><box><size>1 1 {number}</size></box></geometry>"
        "</collision></link>",
        "<joint name='loop' type='fixed'><parent>part4</parent><child>part0</child>"
        "</joint>",
        "<joint name='s' type='screw'><parent>part0</parent><child>part1</child>"
        "<axis><xyz>0 0 1</xyz></axis></joint>",
        "<joint name='g' type='gearbox'><gearbox_ratio>{number}</gearbox_ratio>"
        "</joint>",
        "<static>true</static>",
        "<plugin name='p' filename='libnone.so'/>",
        "<world name='w'><model name='m'/></world>",
        "<mimic joint='to_part1'><multiplier>{number}</multiplier></mimic>",
    ),
    "robot.xacro": (
        '<xacro:include filename="robot.xacro"/>',
        '<xacro:include filename="../none.xacro"/>',
        '<xacro:macro name="again"><xacro:again/></xacro:macro><xacro:again/>',
        '<xacro:macro name="two" params="n"><xacro:if value="${{n}}"><xacro:two '
        'n="${{n - 1}}"/><xacro:two n="${{n - 1}}"/></xacro:if></xacro:macro>'
        '<xacro:two n="{count}"/>',
        '<xacro:property name="a" value="${{b}}"/><xacro:property name="b" '
        'value="${{a}}"/><link name="${{a}}"/>',
        '<link name="${{9**9**9}}"/>',
        "<link name=\"${{'x' * 10**10}}\"/>",
        '<link name="${{[k for k in range(10**9)][0]}}"/>',
        '<link name="${{().__class__.__mro__}}"/>',
        "<link name=\"${{xacro.load_yaml('/etc/hostname')}}\"/>",
        '<link name="$(env HOME)"/>',
        '<link name="$(find none)"/>',
        '<link name="$(eval 1 / 0)"/>',
        '<link name="$(cwd)"/>',
        '<link name="${{1 / 0}}${{undefined}}"/>',
        '<xacro:insert_block name="none"/>',
        '<xacro:element xacro:name="${{name}}"/>',
        '<link name="l"><inertial><mass value="${{float({number})}}"/></inertial>'
        "</link>",
    ),
    "robot.urdf": (
        '<joint name="f" type="floating"><parent link="base"/><child link="arm"/>'
        "</joint>",
        '<joint name="p" type="planar"><parent link="base"/><child link="x"/></joint>'
        '<link name="x"/>',
        '<link name="x"/><joint name="m" type="continuous"><parent link="arm"/><child '
        'link="x"/><mimic joint="{joint}" multiplier="{number}" offset="{number}"/>'
        "</joint>",
        '<joint name="loop" type="fixed"><parent link="arm"/><child link="base"/>'
        "</joint>",
        '<link name="x"><visual><geometry><mesh filename="{path}"/></geometry>'
        "</visual></link>",
    ),
}
"""What is put into a file, after any element that ends."""

SIZE_NAMES = ("nuserdata", "nkey", "njmax", "nconmax", "nuser_body", "memory", "nstack")
NUMBERS = ("nan", "inf", "-inf", "1e400", "1e308", "-1", "0", "1e-320", "2", "0.5")
PATHS = ("robot.urdf", "/dev/zero", "/dev/stdin", "package://none/x.stl", "a" * 5000)
CHOICES = {
    "count": ("0", "-1", "3", "1000", "100000", "2000000000", "1e9", "99999999999"),
    "size": SIZE_NAMES,
    "number": NUMBERS,
    "joint": ("j", "m", "none"),
    "path": PATHS,
}
URDF = b"""<robot name="r">
<link name="base"><inertial><mass value="7"/>
<inertia ixx="1" iyy="1" izz="1.5" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="arm"><inertial><mass value="2"/>
<inertia ixx="1" iyy="1" izz="1.5" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="revolute"><parent link="base"/><child link="arm"/>
<axis xyz="0 0 1"/><limit lower="-1e999" upper="1" velocity="1" effort="1"/></joint>
</robot>
"""


def added_models(random: Random, seeds: Seeds) -> Case:
    """A model with some such pieces, and numbers that are none."""
    models = {**seeds.models, "robot.urdf": URDF}
    name = random.choice(list(PIECES))
    content = models[name]
    for _ in range(random.choice((1, 1, 2, 3))):
        content = _with(random, content, random.choice(PIECES[name]))
    for _ in range(random.choice((0, 0, 1, 2))):
        content = _with_a_number(random, content)
    if random.random() < 0.2:
        content = spoiled(random, content, mutations.TEXT)
    files, robot = {name: content}, name
    if random.random() < 0.2:
        files["of.yaml"] = f"schema: orbident/robot/1\nmodel: {name}\n".encode()
        robot = "of.yaml"
    verb = random.choice(("check", "check", "inspect"))
    shown = random.choice(([], ["--json", "-"], ["--quiet"]))
    return Case("added models", (verb, robot, *shown), files)


def _with(random: Random, content: bytes, piece: str) -> bytes:
    for name, choices in CHOICES.items():
        while f"{{{name}" in piece:
            piece = re.sub(rf"\{{{name}\}}", random.choice(choices), piece, count=1)
    added = piece.replace("{{", "{").replace("}}", "}").encode()
    ends = [found.end() for found in re.finditer(rb"/>|</\w+>|<\w+>", content)]
    # Where the root ends, or anywhere.
    at = random.choice([content.rfind(b"</") % (len(content) + 1)] * len(ends) + ends)
    return content[:at] + added + content[at:]


def _with_a_number(random: Random, content: bytes) -> bytes:
    number = random.choice(NUMBERS)
    return mutations.replaced(random, content, mutations.NUMBER, lambda: number)
