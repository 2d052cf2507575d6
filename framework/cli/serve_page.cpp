#include "serve_page.hpp"

namespace plumbline::cli {

// All text from runs comes in as text nodes: nothing that a node says becomes markup. Colours as in the report, each
// with a word.
const char* const serve_page = R"html(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width,initial-scale=1">
<title>Plumbline runs</title>
<style nonce="@nonce@">
:root{color-scheme:light dark;--bg:#fff;--fg:#1b1f24;--soft:#57606a;--line:#d5dae0;--panel:#f5f7f9;--link:#0b5cad;
--good:#00795a;--doubt:#8f5d00;--bad:#b23a00;--blue:#0072b2}
@media (prefers-color-scheme:dark){:root{--bg:#14181d;--fg:#e6e9ec;--soft:#a0a9b3;--line:#39424c;--panel:#1d232a;--link:#7cb7f0;
--good:#45c9a2;--doubt:#f0b440;--bad:#ff8f52;--blue:#5aaee0}}
*{box-sizing:border-box}
body{margin:0;background:var(--bg);color:var(--fg);font:16px/1.45 system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans","DejaVu Sans",sans-serif;
font-variant-numeric:tabular-nums}
header{padding:14px 24px;border-bottom:1px solid var(--line);display:flex;gap:4px 18px;flex-wrap:wrap;align-items:baseline}
h1{font-size:1.15rem;margin:0}h2{font-size:1.3rem;margin:0 0 2px;overflow-wrap:anywhere}h3{font-size:1rem;margin:22px 0 6px}
a{color:var(--link)}.soft{color:var(--soft)}.small{font-size:.88rem}
#all{display:grid;grid-template-columns:290px minmax(0,1fr);min-height:80vh}
#runs{border-right:1px solid var(--line);padding:10px;overflow-y:auto}
#runs button{display:block;width:100%;text-align:left;font:inherit;color:inherit;background:none;border:1px solid transparent;
border-radius:6px;padding:8px 10px;cursor:pointer;overflow-wrap:anywhere}
#runs button:hover{background:var(--panel)}#runs button[aria-current=true]{background:var(--panel);border-color:var(--line)}
#run{padding:18px 24px 60px;min-width:0}
.good{color:var(--good)}.doubt{color:var(--doubt)}.bad{color:var(--bad)}.going{color:var(--blue)}
.state{font-weight:600}
progress{width:100%;height:10px;accent-color:var(--blue)}
.going-node{margin:6px 0}
pre{background:var(--panel);border:1px solid var(--line);border-radius:6px;padding:12px 14px;overflow-x:auto;font-size:.84rem;line-height:1.4;margin:8px 0}
pre.error{border-left:6px solid var(--bad);white-space:pre-wrap;overflow-wrap:anywhere}
.files{display:flex;flex-wrap:wrap;gap:4px 16px}
.wide{overflow-x:auto}
table{border-collapse:collapse;width:100%;font-size:.9rem}
th,td{padding:5px 9px;text-align:left;border-bottom:1px solid var(--line);vertical-align:top}
th{border-bottom:2px solid var(--soft);font-weight:600}td.n{text-align:right;white-space:nowrap}th.n{text-align:right}
details summary{cursor:pointer}details ul{margin:4px 0;padding-left:20px;overflow-wrap:anywhere}
select{font:inherit;max-width:100%}
#diff,li{overflow-wrap:anywhere}
iframe{width:100%;height:80vh;margin-top:12px;border:1px solid var(--line);border-radius:6px;background:#fff}
@media (max-width:760px){#all{grid-template-columns:minmax(0,1fr)}#runs{border-right:0;border-bottom:1px solid var(--line);max-height:38vh}
#run,header{padding-left:14px;padding-right:14px}.kind{display:none}td.n,th.n{padding-left:4px;padding-right:4px}}
</style></head><body>
<header><h1>Plumbline</h1><span id="where" class="soft"></span><span id="link" class="small soft" role="status"></span></header>
<div id="all"><nav id="runs" aria-label="Runs"></nav><main id="run"></main></div>
<script nonce="@nonce@">
'use strict';
const at=document.getElementById.bind(document);
let chosen=decodeURIComponent(location.hash.slice(1)),followed=!chosen,listText='',runText='',opened=new Set(),shown='',against='',diffText='';
function el(tag,attributes,...children){
  const e=document.createElement(tag);
  for(const[k,v]of Object.entries(attributes||{}))k==='on'?e.addEventListener(v[0],v[1]):v!==null&&v!==false&&e.setAttribute(k,v===true?'':v);
  for(const c of children.flat())if(c!==null&&c!==undefined)e.append(c.nodeType?c:document.createTextNode(c));
  return e}
const tone=s=>({ok:'good',running:'going',executed:'good',reused:'soft',failed:'bad',cancelled:'doubt',skipped:'doubt','not usable':'bad'}[s]||'doubt');
const word=s=>({ok:'done','not usable':'done, but not to be used'}[s]||s);
function duration(s){if(s===null||s===undefined)return'';if(s<100)return(s<1?s.toFixed(2):s.toFixed(1))+' s';
  const m=Math.round(s/60);return m<60?m+' min':Math.floor(m/60)+' h '+m%60+' min'}
const path=(id,file)=>'/files/'+(id==='.'?file:id+'/'+file).split('/').map(encodeURIComponent).join('/');
function age(t){return t?t.replace('T',' ').replace('Z',' UTC'):''}
function number(v){return v===null?'not known':Math.abs(v)>=1e5||v!==0&&Math.abs(v)<1e-4?v.toExponential(3):String(+v.toPrecision(6))}
function percent(p){return p.items>1?p.items_done/p.items:p.fraction}
function drawList(list){
  at('where').textContent=list.folder;
  const nodes=list.runs.map(r=>el('button',{'aria-current':String(r.id===chosen),on:['click',()=>choose(r.id)]},
    el('div',{},r.id==='.'?r.pipeline:r.id),
    el('div',{class:'small'},el('span',{class:'state '+tone(r.status)},word(r.status)),' ',
      el('span',{class:'soft'},r.progress&&r.progress.total?r.progress.done+' of '+r.progress.total+' nodes':duration(r.seconds))),
    el('div',{class:'small soft'},age(r.time))));
  at('runs').replaceChildren(...(nodes.length?nodes:[el('p',{class:'soft'},'No run yet. One that is started with its output here appears by itself.')]))}
function choose(id){chosen=id;followed=false;runText='';shown='';against='';diffText='';location.hash=encodeURIComponent(id);listText='';tick()}
function fold(key,summary,...content){
  const d=el('details',{open:opened.has(key)},el('summary',{},summary),...content);
  d.addEventListener('toggle',()=>d.open?opened.add(key):opened.delete(key));return d}
function nodeRow(run,n){
  const key=n.name+'@'+(n.round||0),parts=[];
  if(n.error)parts.push(el('pre',{class:'error'},n.error));
  if((n.warnings||[]).length)parts.push(el('div',{},'Warnings'),el('ul',{},n.warnings.map(w=>el('li',{},w))));
  if((n.messages||[]).length)parts.push(el('ul',{},n.messages.map(w=>el('li',{},w))));
  if((n.metrics||[]).length)parts.push(el('ul',{},n.metrics.map(m=>el('li',{},m.name+': '+number(m.value)+(m.unit==='1'?'':' '+m.unit)))));
  const outputs=Object.entries(n.outputs||{}).filter(([,h])=>h.length);
  if(outputs.length)parts.push(el('ul',{},outputs.map(([port,hashes])=>el('li',{},port+' ',el('span',{class:'soft'},(n.types||{})[port]||''),' ',
    ...hashes.slice(0,20).map((h,i)=>el('a',{href:'/api/artifact?id='+encodeURIComponent(run.id)+'&node='+encodeURIComponent(n.name)+'&port='+encodeURIComponent(port)+'&item='+i,target:'_blank',rel:'noopener'},hashes.length>1?String(i+1)+' ':'JSON')),
    hashes.length>20?' and '+(hashes.length-20)+' more':''))));
  const name=n.name+(n.round?' (round '+n.round+')':''),mark=(n.warnings||[]).length?' · '+n.warnings.length+(n.warnings.length>1?' warnings':' warning'):'';
  return el('tr',{},el('td',{},parts.length?fold(key,name+mark,...parts):name),el('td',{class:'kind soft'},n.kind),
    el('td',{class:tone(n.status)},n.status),el('td',{class:'n'},n.items>1?(n.items_executed<n.items?n.items_executed+' of '+n.items:String(n.items)):''),
    el('td',{class:'n'},n.status==='executed'||n.status==='failed'?duration(n.seconds):''))}
function going(p){
  if(!p)return[];
  const parts=[];
  if(p.total)parts.push(el('progress',{max:p.total,value:p.done,'aria-label':'nodes'}),el('div',{class:'small soft'},p.done+' of '+p.total+' nodes'));
  for(const n of p.running){const f=percent(n);
    parts.push(el('div',{class:'going-node'},el('div',{},el('b',{},n.name),' ',el('span',{class:'soft'},n.items>1?n.items_done+' of '+n.items+' items':n.text)),
      f>0?el('progress',{max:1,value:f,'aria-label':n.name}):el('progress',{'aria-label':n.name})))}
  return parts}
function drawRun(run,list){
  const pages=run.files.filter(f=>f.endsWith('.html'));
  const others=list.runs.filter(r=>r.id!==run.id);
  const select=el('select',{'aria-label':'compare with',on:['change',e=>{against=e.target.value;diffText='';runText='';compare(run.id)}]},
    el('option',{value:''},'compare with …'),others.map(r=>el('option',{value:r.id,selected:r.id===against},r.id+' · '+age(r.time))));
  const old=at('page'),frame=shown&&pages.includes(shown)?(old&&old.dataset.of===run.id+'/'+shown+run.time?old:el('iframe',{id:'page',title:shown,
    src:path(run.id,shown),sandbox:'allow-scripts allow-popups allow-downloads','data-of':run.id+'/'+shown+run.time})):null;
  const top=el('div',{},
    el('h2',{},run.id==='.'?run.pipeline:run.id),
    el('div',{},el('span',{class:'state '+tone(run.status)},word(run.status)),' ',el('span',{class:'soft'},[run.pipeline,...run.arguments].join(' '))),
    el('div',{class:'small soft'},[age(run.time),run.seconds?duration(run.seconds):'',run.host?'on '+run.host:''].filter(Boolean).join(' · ')),
    ...going(run.progress),
    run.error?el('pre',{class:'error'},run.error):null,
    run.words?el('pre',{},run.words):null,
    run.files.length?el('h3',{},'Files'):null,
    el('div',{class:'files'},run.files.map(f=>el('a',{href:path(run.id,f),target:'_blank',rel:'noopener',on:['click',e=>{if(pages.includes(f)&&innerWidth>760){e.preventDefault();shown=shown===f?'':f;runText='';tick()}}]},f))));
  const below=el('div',{},
    el('h3',{},'Nodes'),
    el('div',{class:'wide'},el('table',{},el('thead',{},el('tr',{},el('th',{},'node'),el('th',{class:'kind'},'kind'),el('th',{},''),el('th',{class:'n'},'items'),el('th',{class:'n'},'time'))),
      el('tbody',{},run.nodes.map(n=>nodeRow(run,n))))),
    others.length?el('h3',{},'Difference'):null,others.length?select:null,el('div',{id:'diff'}));
  if(frame&&frame===old){at('top').replaceChildren(top);at('below').replaceChildren(below)}
  else at('run').replaceChildren(el('div',{id:'top'},top),...(frame?[frame]:[]),el('div',{id:'below'},below));
  drawDiff()}
function drawDiff(){
  const place=at('diff');if(!place)return;
  if(!against||!diffText){place.replaceChildren(...(against?[el('p',{class:'soft'},'comparing …')]:[]));return}
  let d;try{d=JSON.parse(diffText)}catch(e){place.replaceChildren(el('p',{class:'bad'},diffText));return}
  place.replaceChildren(...(d.nodes.length?d.nodes.map(n=>el('div',{},el('b',{},n.node),el('ul',{},n.differences.map(x=>el('li',{},x))))):
    [el('p',{},'No node differs: the results agree.')]))}
async function compare(id){
  if(!against){drawDiff();return}
  const other=against,answer=await fetch('/api/diff?a='+encodeURIComponent(other)+'&b='+encodeURIComponent(id)).then(r=>r.text()).catch(String);
  if(other===against&&id===chosen){diffText=answer;drawDiff()}}
let busy=false;
async function tick(){
  if(busy)return;busy=true;
  try{
    const answer=await fetch('/api/runs');
    if(answer.status===401){at('link').textContent='The token is not (or no longer) that of this server: open the address that plumbline serve printed';return}
    const text=await answer.text(),list=JSON.parse(text);
    at('link').textContent='';
    if(followed&&list.runs.length)chosen=list.runs[0].id;
    if(text+chosen!==listText){listText=text+chosen;drawList(list)}
    if(chosen){
      const r=await fetch('/api/run?id='+encodeURIComponent(chosen)),t=await r.text();
      if(t!==runText){runText=t;r.ok?drawRun(JSON.parse(t),list):at('run').replaceChildren(el('p',{class:'soft'},'This run is not there any more.'))}
    }
  }catch(e){at('link').textContent='plumbline serve does not answer; this page goes on by itself when it does'}
  finally{busy=false}}
addEventListener('hashchange',()=>{const id=decodeURIComponent(location.hash.slice(1));if(id&&id!==chosen)choose(id)});
setInterval(()=>{if(!document.hidden)tick()},1000);tick();
</script></body></html>
)html";

}  // namespace plumbline::cli
